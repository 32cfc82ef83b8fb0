"""Finds installed engines, and archives episodes."""
