"""Lint rules for specs, and a dry run that builds some of their scenes."""
