"""Caches of scenes, traces and pictures."""
