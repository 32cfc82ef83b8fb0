"""What a counterfactual changed, in words."""

from __future__ import annotations

from wmspec.ask.model import Change
from wmspec.ask.verbalize import say
from wmspec.check.ir import Counterfactual
from wmspec.check.orbits import level_words
from wmspec.layout.values import Values


def change_of(change: Counterfactual, before: Values, after: Values) -> Change:
    """What it was before and what it became."""
    if change.change == "without":
        return Change("without", change.owner, "done", "left out")
    if change.change == "add":
        return Change("add", change.owner, "left out", "done")
    if change.change == "levels":
        return _levels(change, before)
    if change.change == "order":
        starts = {name: before.property(name, "start") for name in (change.owner, change.property)}
        first, second = sorted(starts, key=lambda name: starts[name])
        return Change("order", f"{first}, {second}", f"{first} first", f"{second} first")
    owner, name = change.owner, change.property
    was = say(before.property(owner, name), change.sort, before) if before.has(owner, name) else "unset"
    return Change(change.change, f"{owner}.{name}", was, say(after.property(owner, name), change.sort, after))


def _levels(change: Counterfactual, before: Values) -> Change:
    """Other levels of those factors that differ."""
    differing = [name for name, level in change.levels.items() if before.own[name] != level]
    factors = [before.spec.factor(name) for name in differing]
    was = [level_words(factor, before.own[factor.name]) for factor in factors]
    became = [level_words(factor, change.levels[factor.name]) for factor in factors]
    return Change("levels", ", ".join(differing), ", ".join(was), ", ".join(became))
