"""Verification: recomputes a dataset from its specs and seed, and compares."""
