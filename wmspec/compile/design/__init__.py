"""Designs: factor values of every instance, each computed from the instance's index."""
