"""The simulated world: shapes, scenes, the USD reader and the photo renderer. Knows neither the language nor the engines."""
