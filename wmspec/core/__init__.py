"""Shared by all wings: diagnostics, limits, guarded files, randomness, vectors. Imports nothing else of wmspec."""
