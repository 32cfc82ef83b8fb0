"""Features of options and pictures."""

from __future__ import annotations

import numpy as np

from wmspec.dataset.audit.features import principal_components


def test_components_are_those_that_vary_and_not_rounding_errors() -> None:
    draw = np.random.default_rng(0).normal(size=(60, 2))
    x = np.column_stack([draw, draw @ [1.0, 2.0], draw[:, 0] / 3, np.full(60, 0.1)])  # rank 2
    seen = principal_components(x, 4)
    assert seen.shape == (60, 2)
    assert np.allclose(seen.T @ seen, np.diag(np.diag(seen.T @ seen)))
    assert np.isclose((seen**2).sum(), ((x - x.mean(0)) ** 2).sum())


def test_there_is_one_component_even_if_nothing_varies() -> None:
    assert principal_components(np.ones((10, 3)), 2).shape == (10, 1)
