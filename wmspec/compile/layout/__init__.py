"""What a scene is in numbers, for one assignment of the factors: the values of properties, and where everything is."""
