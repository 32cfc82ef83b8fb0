"""Scores clips of video models: which of the simulated futures of a question a clip shows, or that it shows none."""
