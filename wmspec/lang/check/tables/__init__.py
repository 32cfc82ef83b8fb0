"""Tables of the language: properties, verbs, functions, colours."""
