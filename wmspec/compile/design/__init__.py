"""From a task and an index to an instance: which value every factor has, and what the scene then is in numbers."""
