"""Results that are computed once: a bounded cache, and results that are stored with the object they are about."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class LRU(Generic[K, V]):
    """The values that were used last, by key.

    Their weights add up to at most `size`, or there is only one; a weight is 1 unless `weigh` returns another. `drop`
    is called with each value that makes room for others.
    """

    def __init__(
        self, size: int, *, weigh: Callable[[V], int] = lambda _: 1, drop: Callable[[V], object] = lambda _: None
    ) -> None:
        self._room, self._weigh, self._drop = size, weigh, drop
        self._values: OrderedDict[K, V] = OrderedDict()

    def __len__(self) -> int:
        return len(self._values)

    def find(self, key: K) -> V | None:
        """The value of a key, or None."""
        if key in self._values:
            self._values.move_to_end(key)
        return self._values.get(key)

    def get(self, key: K, make: Callable[[], V]) -> V:
        """The value of a key; `make` makes it if there is none."""
        if key not in self._values:
            return self.put(key, make())
        self._values.move_to_end(key)
        return self._values[key]

    def put(self, key: K, value: V) -> V:
        """Store a value under a key that has none, and return it."""
        self._values[key] = value
        self._room -= self._weigh(value)
        while self._room < 0 and len(self) > 1:
            self._drop(self.pop(next(iter(self._values))))
        return value

    def pop(self, key: K) -> V:
        """Remove the value of a key and return it, without `drop`. Raises KeyError if there is none."""
        value = self._values.pop(key)
        self._room += self._weigh(value)
        return value

    def clear(self) -> None:
        """Drop all values."""
        while self._values:
            self._drop(self.pop(next(iter(self._values))))


def cached_on(owner: Any, compute: Callable[..., V], *arguments: Hashable) -> V:
    """What `compute(owner, *arguments)` returns, computed once and stored with the owner.

    The owner must never change. `compute` is a function of a module, since the owner may be pickled; what is stored is
    no field, so that copies, comparisons and hashes leave it out.
    """
    results: dict[Any, V] = owner.__dict__.setdefault("_cached", {})
    key = (compute, *arguments)
    if key not in results:
        results[key] = compute(owner, *arguments)
    return results[key]
