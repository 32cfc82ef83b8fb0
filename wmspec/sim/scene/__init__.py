"""The scene that every backend executes and renders: read from USD, free of USD types."""
