"""Types and units."""
