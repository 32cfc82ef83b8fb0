"""The simulated world: shapes, scenes, the USD reader and the photo renderer. Independent of language and engines."""
