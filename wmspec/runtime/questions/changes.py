"""Describes the change of a counterfactual in words."""

from __future__ import annotations

from collections.abc import Sequence

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.lang.check.ir.ir import Counterfactual, OrbitFactor
from wmspec.lang.check.statements.orbits import level_words
from wmspec.runtime.questions.model import Change
from wmspec.runtime.questions.verbalize import verbalize


def change_of(change: Counterfactual, orbit: Sequence[OrbitFactor], before: Evaluator, after: Evaluator) -> Change:
    """Return the change with values before and after."""
    if change.change == "without":
        done = "done" if before.spec.thing(change.owner).kind == "action" else "there"
        return Change("without", change.owner, done, "left out")
    if change.change == "add":
        return Change("add", change.owner, "left out", "done")
    if change.change == "levels":
        return _levels(change, orbit, before)
    if change.change == "order":
        starts = {name: before.number(name, "start") for name in (change.owner, change.property)}
        first, second = sorted(starts, key=lambda name: starts[name])
        return Change("order", f"{first}, {second}", f"{first} first", f"{second} first")
    owner, name = change.owner, change.property
    was = verbalize(before.property(owner, name), change.sort, before) if before.has(owner, name) else "unset"
    return Change(change.change, f"{owner}.{name}", was, verbalize(after.property(owner, name), change.sort, after))


def _levels(change: Counterfactual, orbit: Sequence[OrbitFactor], before: Evaluator) -> Change:
    """Return the changed levels; for a closed set, as changes of state or action."""
    reads: dict[str, tuple[str, ...]] = {v.factor: _READS[v.reads] for v in orbit}
    made: Change | None = None
    for name, level in reversed(change.levels.items()):
        factor, was = before.spec.factor(name), before.own[name]
        for kind in reversed(reads.get(name, ("levels",))) if was != level else ():
            made = Change(kind, name, level_words(factor, was), level_words(factor, level), made)
    assert made is not None
    return made


_READS: dict[str, tuple[str, ...]] = {"state": ("state",), "action": ("action",), "both": ("state", "action")}
