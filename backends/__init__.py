"""Engines, one package each with the same structure. They import only `wmspec.sim` and `wmspec.core`."""
