"""The typed intermediate representation that the checker returns."""
