"""Evaluation of models: reads datasets and writes results, without engines."""
