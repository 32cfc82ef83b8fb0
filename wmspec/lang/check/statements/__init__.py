"""Checks the statements of a task: objects, actions, factors, questions."""
