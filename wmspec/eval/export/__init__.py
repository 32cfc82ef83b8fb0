"""Exports of a dataset for other evaluation tools."""
