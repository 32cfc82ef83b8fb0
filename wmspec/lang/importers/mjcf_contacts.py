"""Which bodies of a compiled MJCF model pass through each other, by MuJoCo's rules.

A geom collides with another one if a bit of `contype` of either is in `conaffinity` of the other. Bodies that are
welded to one another, parent and child unless the parent never moves, and excluded pairs do not collide.
"""

from __future__ import annotations

from itertools import combinations

from wmspec.lang.importers.mjcf_model import Compiled
from wmspec.lang.importers.model import Faults

_Bits = frozenset[tuple[int, int]]
#: Bits of the objects of a spec.
_OTHERS = (1, 1)


class Contacts:
    """Finds pairs of bodies that pass through each other."""

    def __init__(self, compiled: Compiled, faults: Faults) -> None:
        self._compiled, self._m, self._faults = compiled, compiled.model, faults

    def passing(self) -> dict[int, tuple[int, ...]]:
        """Return for each body the later bodies that it passes through; 0 is the world."""
        m = self._m
        bits = {i: self._bits(i) for i in range(int(m.nbody))}
        excluded = {frozenset((int(s) >> 16, int(s) & 0xFFFF)) for s in m.exclude_signature}
        passes: dict[int, list[int]] = {}
        known: dict[tuple[_Bits, _Bits], bool] = {}
        for i, j in combinations([i for i, own in bits.items() if own], 2):
            key = (bits[i], bits[j])
            if key not in known:
                known[key] = self._pass(*key)
            if self._joined(i, j):
                continue  # their joint says it
            if known[key] or frozenset((i, j)) in excluded or self._welded(i, j):
                passes.setdefault(i, []).append(j)
        self._against_others()
        return {i: tuple(others) for i, others in passes.items()}

    def _bits(self, body: int) -> _Bits:
        m, first = self._m, int(self._m.body_geomadr[body])
        geoms = range(first, first + int(m.body_geomnum[body]))
        kinds = self._compiled.mujoco.mjtGeom
        left_out = (kinds.mjGEOM_PLANE, kinds.mjGEOM_HFIELD)
        if not self._compiled.has_contacts:
            return frozenset()
        pairs = ((int(m.geom_contype[g]), int(m.geom_conaffinity[g])) for g in geoms if m.geom_type[g] not in left_out)
        return frozenset(pair for pair in pairs if any(pair))

    def _pass(self, first: _Bits, second: _Bits) -> bool:
        """Whether no geom of one body collides with one of the other; reports pairs of which some do."""
        met = [_collide(a, b) for a in first for b in second]
        if any(met) and not all(met):
            what = "bodies of which only some geoms collide with one another are not supported"
            self._faults.approximate(self._compiled.bodies[0].where, what, "all collide", "split the body")
        return not any(met)

    def _against_others(self) -> None:
        """Report geoms that collide within the asset and not with other objects."""
        for g in range(int(self._m.ngeom) if self._compiled.has_contacts else 0):
            own = int(self._m.geom_contype[g]), int(self._m.geom_conaffinity[g])
            if any(own) and not _collide(own, _OTHERS):
                what = "geoms that collide with the asset alone, by contype and conaffinity, are not supported"
                self._faults.approximate(
                    self._compiled.geoms[g].where, what, "it collides with all objects", "set bit 1"
                )

    def _joined(self, i: int, j: int) -> bool:
        """Whether one joint connects the second body to the first, its parent."""
        return int(self._m.body_parentid[j]) == i and int(self._m.body_jntnum[j]) <= 1

    def touches_parent(self, body: int) -> bool:
        """Whether a body collides with its parent: if that never moves, and their geoms collide."""
        parent = int(self._m.body_parentid[body])
        if int(self._m.body_weldid[parent]) != 0 or int(self._m.body_weldid[body]) == 0:
            return False
        excluded = any({int(s) >> 16, int(s) & 0xFFFF} == {parent, body} for s in self._m.exclude_signature)
        first, second = self._bits(parent), self._bits(body)
        return bool(first and second) and not excluded and any(_collide(a, b) for a in first for b in second)

    def _welded(self, i: int, j: int) -> bool:
        """Whether MuJoCo filters a pair as parts of one rigid group, or as a group and its parent that moves."""
        m = self._m
        a, b = int(m.body_weldid[i]), int(m.body_weldid[j])
        above_a, above_b = (int(m.body_weldid[m.body_parentid[w]]) for w in (a, b))
        return a == b or (above_a == b and b != 0) or (above_b == a and a != 0)


def _collide(a: tuple[int, int], b: tuple[int, int]) -> bool:
    return bool(a[0] & b[1] or b[0] & a[1])
