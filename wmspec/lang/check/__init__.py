"""Checker: syntax trees to a checked, typed `TaskSpec`."""
