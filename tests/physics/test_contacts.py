"""From which pairs touch in each step to contacts: when a pair begins and ends to touch, whatever flickers."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wmspec.sim.scene.physics.contact import Pair, intervals

NAMES = ("floor", "ball", "crate")
PAIRS: list[Pair] = [(0, 1), (0, 2), (1, 2)]
STEP = 0.25  # s


@given(
    st.lists(st.tuples(st.frozensets(st.sampled_from(PAIRS)), st.integers(1, 4)), max_size=8),
    st.integers(0, 3),
    st.booleans(),
)
def test_a_contact_lasts_until_its_pair_has_parted(
    stretches: list[tuple[frozenset[Pair], int]], gap: int, shared: bool
) -> None:
    """Against the definition, for steps that share one set and steps that have equal ones."""
    touching = [pairs if shared else frozenset(set(pairs)) for pairs, steps in stretches for _ in range(steps)]
    expected = []
    for pair in PAIRS:
        steps = [i for i, pairs in enumerate(touching) if pair in pairs]
        begun = [i for k, i in enumerate(steps) if k == 0 or i - steps[k - 1] - 1 > gap]
        for start in begun:
            later = [i for i in begun if i > start]
            last = max(i for i in steps if not later or i < later[0])
            expected.append((start * STEP, (last + 1) * STEP, *(NAMES[i] for i in pair)))
    found = [(c.start, c.stop, c.first, c.second) for c in intervals(touching, NAMES, STEP, gap * STEP)]
    assert sorted(found) == sorted(expected)
    assert [contact[0] for contact in found] == sorted(contact[0] for contact in found)
