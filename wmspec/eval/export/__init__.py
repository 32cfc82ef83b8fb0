"""A dataset as a folder that other tools of evaluation run as it is."""
