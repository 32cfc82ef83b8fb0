"""The tables of the language: properties, verbs, functions, colours."""
