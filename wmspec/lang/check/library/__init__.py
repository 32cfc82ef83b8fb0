"""Expands libraries, templates and asset files."""
