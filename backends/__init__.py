"""The engines: one package each, of equal shape. Each needs only `wmspec.sim.scene` and `wmspec.core.diagnostics`."""
