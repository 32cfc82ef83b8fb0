"""Quaternions: one by one and many at once they turn alike, to the bit, and as SciPy's do."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from wmspec.sim.scene.model import Array
from wmspec.sim.scene.model.transform import multiply, rotate, rotation

MANY = 5
FINITE = st.floats(-1e3, 1e3, allow_subnormal=False)
QUATERNIONS = arrays(np.float64, (MANY, 4), elements=FINITE)
VECTORS = arrays(np.float64, (MANY, 3), elements=FINITE)


@given(QUATERNIONS, QUATERNIONS, VECTORS)
def test_one_by_one_equals_all_at_once(a: Array, b: Array, v: Array) -> None:
    assert np.array_equal(np.array([multiply(*pair) for pair in zip(a, b, strict=True)]), multiply(a, b))
    assert np.array_equal(np.array([rotate(*pair) for pair in zip(a, v, strict=True)]), rotate(a, v))
    assert np.array_equal(np.array([rotation(one) for one in a]), rotation(a))
    assert rotation(a[0]).flags.f_contiguous == rotation(a)[0].flags.f_contiguous  # or products would round otherwise


@given(QUATERNIONS.filter(lambda q: bool((np.linalg.norm(q, axis=1) > 1e-3).all())), VECTORS)
def test_they_turn_as_those_of_scipy(q: Array, v: Array) -> None:
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    theirs = Rotation.from_quat(q[:, [1, 2, 3, 0]])
    np.testing.assert_allclose(rotate(q, v), theirs.apply(v), atol=1e-9)
    np.testing.assert_allclose(rotation(multiply(q, q[::-1])), (theirs * theirs[::-1]).as_matrix(), atol=1e-12)
