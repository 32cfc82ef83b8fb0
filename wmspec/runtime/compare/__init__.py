"""Compares episodes across engines: trajectories, answers, and causes of differences."""
