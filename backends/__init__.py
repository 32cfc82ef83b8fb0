"""The engines: one package each, of equal shape. Each needs only `wmspec.scene` and `wmspec.core.diagnostics`."""
