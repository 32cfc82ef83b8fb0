"""Layout: evaluates the properties of a spec for one assignment of its factors, and places all objects."""
