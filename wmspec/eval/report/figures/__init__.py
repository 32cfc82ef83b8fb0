"""Figures of a report, drawn with matplotlib as deterministic SVG."""
