"""Cameras, light, shadows and colours shared by all renderers."""
