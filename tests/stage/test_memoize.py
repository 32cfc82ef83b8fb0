"""A bounded cache returns what an unbounded one would, and keeps what was used last."""

from __future__ import annotations

import copy
import pickle
from dataclasses import dataclass, replace
from functools import partial

from hypothesis import given
from hypothesis import strategies as st

from wmspec.core.memoize import LRU, cached_on


@given(st.lists(st.integers(0, 9)), st.integers(1, 5))
def test_the_values_used_last_are_kept(keys: list[int], size: int) -> None:
    made: list[int] = []
    dropped: list[int] = []
    cache: LRU[int, int] = LRU(size, drop=dropped.append)

    def make(key: int) -> int:
        made.append(key)
        return -key

    for i, key in enumerate(keys):
        latest = list(dict.fromkeys(reversed(keys[:i])))[:size]
        known = len(made)
        assert cache.get(key, partial(make, key)) == -key
        assert (len(made) == known) == (key in latest)
        assert len(cache) <= size
    assert len(made) == len(dropped) + len(cache)


@given(st.lists(st.integers(1, 9), min_size=1), st.integers(1, 20))
def test_weights_are_bounded_unless_one_value_is_too_heavy(weights: list[int], size: int) -> None:
    cache: LRU[int, int] = LRU(size, weigh=lambda weight: weight)
    for i, weight in enumerate(weights):
        cache.put(i, weight)
        kept = [w for j, w in enumerate(weights) if cache.find(j) is not None and j <= i]
        assert len(kept) == len(cache)
        assert sum(kept) <= size or len(kept) == 1
    cache.clear()
    assert len(cache) == 0


def test_popped_value_makes_room_and_is_not_closed() -> None:
    dropped: list[str] = []
    cache: LRU[int, str] = LRU(2, drop=dropped.append)
    cache.put(1, "a")
    cache.put(2, "b")
    assert cache.pop(1) == "a"
    cache.put(3, "c")
    assert dropped == []
    cache.put(4, "d")
    assert dropped == ["b"]


@dataclass(frozen=True)
class Owner:
    size: int


def double(owner: Owner, times: int = 1) -> list[int]:
    return [owner.size * 2 * times]


def test_result_belongs_to_its_owner_and_copies_take_no_wrong_one() -> None:
    owner = Owner(2)
    assert cached_on(owner, double) is cached_on(owner, double)
    assert cached_on(owner, double, 3) == [12]
    assert cached_on(replace(owner, size=5), double) == [10]
    assert owner == Owner(2)
    for other in (copy.deepcopy(owner), pickle.loads(pickle.dumps(owner))):
        assert (other, cached_on(other, double)) == (owner, [4])
