"""The order of the members of control groups: a permutation of the key, so that an index tells no level."""

from __future__ import annotations

from wmspec.core.rng import Permutation


class MemberOrder:
    """Permutes the members of every group in its own way, in constant memory.

    The position of a member in its group and its place in the arrangement of the group correspond one to one.
    """

    def __init__(self, *key: object) -> None:
        self._key = key
        self._latest: tuple[tuple[int, int], Permutation] = ((-1, 0), Permutation(0))

    def place(self, group: int, size: int, position: int) -> int:
        """Return the place in the arrangement of the member at a position of a group of `size` members."""
        return self._of(group, size)(position)

    def position(self, group: int, size: int, place: int) -> int:
        """Return the position of the member at a place in the arrangement."""
        return self._of(group, size).inverse(place)

    def _of(self, group: int, size: int) -> Permutation:
        """Return the permutation of a group; the latest one is cached."""
        known, permutation = self._latest
        if known != (group, size):
            permutation = Permutation(size, *self._key, group)
            self._latest = ((group, size), permutation)
        return permutation
