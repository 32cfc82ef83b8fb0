"""Features of options and pictures."""

from __future__ import annotations

import numpy as np
import pytest

from wmspec.dataset.audit.features import principal_components
from wmspec.dataset.audit.probes import MAX_PAIRED_PICTURES, view_sets


def test_components_are_those_that_vary_and_not_rounding_errors() -> None:
    draw = np.random.default_rng(0).normal(size=(60, 2))
    x = np.column_stack([draw, draw @ [1.0, 2.0], draw[:, 0] / 3, np.full(60, 0.1)])  # rank 2
    seen = principal_components(x, 4)
    assert seen.shape == (60, 2)
    assert np.allclose(seen.T @ seen, np.diag(np.diag(seen.T @ seen)))
    assert np.isclose((seen**2).sum(), ((x - x.mean(0)) ** 2).sum())


def test_there_is_one_component_even_if_nothing_varies() -> None:
    assert principal_components(np.ones((10, 3)), 2).shape == (10, 1)


@pytest.mark.parametrize("shown", range(1, 20))
def test_every_picture_is_seen_alone_and_some_in_pairs_from_the_first_to_the_last(shown: int) -> None:
    views = list(view_sets(shown))
    assert [view for view in views if len(view) == 1] == [(n,) for n in range(shown)]
    pairs = [view for view in views if len(view) == 2]
    paired = {n for pair in pairs for n in pair}
    assert len(pairs) == len(set(pairs)) == len(paired) * (len(paired) - 1) // 2
    if shown > 2:
        assert len(paired) == min(shown, MAX_PAIRED_PICTURES)
        assert (0, shown - 1) in pairs
    else:
        assert not pairs  # the two are all of them
