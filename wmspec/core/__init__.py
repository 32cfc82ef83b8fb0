"""Shared by all wings: diagnostics, limits, guarded file access, randomness, vectors. Imports nothing else of wmspec."""
