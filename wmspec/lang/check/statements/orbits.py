"""Checks orbits (closed sets of options) and counterfactuals of each other level."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from math import prod
from typing import Literal

from wmspec.core.diagnostics import suggestion
from wmspec.core.places import Location, Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import Failed
from wmspec.lang.check.ir import ir
from wmspec.lang.check.ir.evaluate import reachable
from wmspec.lang.check.tables.vocabulary import DESIGNS
from wmspec.lang.check.types import units
from wmspec.lang.parse import syntax as s

#: Number of options of a closed set.
MIN_OPTIONS, MAX_OPTIONS = 2, 8


class Orbits:
    """Checks orbits and `each other`, given the rest of the task; an error is reported and raises `Failed`."""

    def __init__(
        self,
        check: Expressions,
        plan: ir.Plan,
        factors: Iterable[ir.Factor],
        lets: Iterable[ir.Let],
        requires: Iterable[ir.Require],
        things: Sequence[ir.Entity],
    ) -> None:
        self.check = check
        self.plan = plan
        self.factors = {f.name: f for f in factors if not f.nuisance}
        self.lets = {let.name: let.value for let in lets}
        self.requires = tuple(requires)
        self.things = things

    # ------------------------------------------------------------ closed sets of options

    def orbit(self, clause: s.Clause) -> tuple[tuple[ir.OrbitFactor, ...], tuple[ir.Counterfactual, ...]]:
        """Return the factors of `options orbit of ...`, and a counterfactual for every combination of their levels."""
        assert isinstance(clause.value, s.Items)
        varied: dict[str, ir.OrbitFactor] = {}
        for item in clause.value.items:
            name = item.span.text
            if name in varied:
                self.check.fail("WMS202", f"`{name}` is named twice", item.span, "name it once")
            varied[name] = self._varied(name, item.span)
        sizes = [len(self._values(name)) for name in varied]
        if not MIN_OPTIONS <= prod(sizes) <= MAX_OPTIONS:
            many = " x ".join(map(str, sizes))
            what = f"this orbit has {many}{f' = {prod(sizes)}' if len(sizes) > 1 else ''} options"
            remedy = f"a question has {MIN_OPTIONS} to {MAX_OPTIONS}: name other factors, or give them other values"
            self.check.fail("WMS508", what, clause.value.span, remedy)
        return tuple(varied.values()), tuple(self._siblings(tuple(varied), Location.of(clause.span)))

    def _varied(self, name: str, span: Span) -> ir.OrbitFactor:
        factor = self._factor(name, span)
        others = DESIGNS.keys() - {"groups"}
        if self.plan.kind != "groups" and any(d.kind.id not in others for d in self.check.scope.designs):
            raise Failed  # the design's error was reported
        if self.plan.kind != "groups":
            what = "the options of an orbit are siblings in a group, and this design has no groups"
            remedy = f"write `design groups of 100 {{ cross: {name} }}`"
            self.check.fail("WMS508", what, span, remedy)
        if name not in self.plan.cross:
            turns = "takes turns, so that not every group has its siblings"
            what = f"`{name}` {turns if name in self.plan.turn else 'is not crossed in the groups'}"
            self.check.fail("WMS508", what, span, f"put `{name}` into the `cross` of the design")
        assert isinstance(factor.domain, ir.Choices)
        tied = next((r for r in self.requires if name in self._refs(r.condition)), None)
        if factor.domain.when is not None or tied is not None:
            why = f"`require {tied.text}` ties" if tied else "its domain ties"
            what = f"{why} `{name}`, so that some groups may lack some of its levels"
            self.check.fail("WMS508", what, span, "let conditions be about other factors")
        reads = self._reads(name)
        if reads is None and self.check.report.failed:
            raise Failed  # an erroneous statement may refer to it
        if reads is None:
            what = f"nothing in the scene depends on `{name}`, so siblings that differ in it look alike"
            self.check.fail("WMS508", what, span, "let an object or an action depend on it")
        return ir.OrbitFactor(factor=name, reads=reads)

    def _reads(self, name: str) -> Literal["state", "action", "both"] | None:
        """Return whether the initial state, the action or both depend on a factor; None if neither."""
        read = set[bool]()
        for thing in self.things:
            refs = (ref for setting in thing.properties.values() for ref in self._refs(setting.value))
            if name in refs:
                read.add(thing.kind == "action")
        if not read:
            return None
        return "both" if len(read) == 2 else "action" if True in read else "state"

    def _siblings(self, names: Sequence[str], place: Location) -> Iterator[ir.Counterfactual]:
        """Yield every combination, the last factor fastest."""
        for levels in product(*map(self._values, names)):
            yield _otherwise(self.factors, dict(zip(names, levels, strict=True)), place)

    # ------------------------------------------------------------ each other level

    def each_other(self, written: s.EachOther) -> tuple[ir.Counterfactual, ...]:
        """Return a counterfactual for every level of a factor or of the factor that sets an argument."""
        target, place = written.target, Location.of(written.span)
        if isinstance(target, s.Name):
            self._free(target.id, target.span)
            return tuple(self._siblings((target.id,), place))
        if not isinstance(target, s.Member) or not isinstance(target.value, s.Name):
            what = "`each other` expects a factor, or an argument that a factor gives"
            self.check.fail("WMS503", what, target.span, "write something like `each other pace` or `push.speed`")
        owner = next((t for t in self.things if t.name == target.value.id), None)
        setting = owner.properties.get(target.name.id) if owner else None
        if owner is None or setting is None or not isinstance(setting.value, ir.Ref):
            self.check.infer(target)
            what = f"`{target.span.text}` is not given by a factor, so it has no other levels"
            remedy = "let a factor give it, or write a counterfactual for each value"
            self.check.fail("WMS503", what, target.span, remedy)
        name = setting.value.name
        self._free(name, target.span)
        change: ir.Change = "action" if owner.kind == "action" else "state"
        typed = self.check.infer(target)
        return tuple(
            ir.Counterfactual(
                name=_slug(self.factors[name], level),
                change=change,
                owner=owner.name,
                property=target.name.id,
                value=_constant(level),
                sort=str(typed.type),
                levels={name: level},
                place=place,
            )
            for level in self._values(name)
        )

    def _free(self, name: str, span: Span) -> None:
        """Report a name that is no factor with freely available levels."""
        factor = self._factor(name, span)
        if not isinstance(factor.domain, ir.Choices) or factor.domain.when is not None:
            what = f"which other levels `{name}` can have depends on the instance"
            self.check.fail("WMS503", what, span, "give it a list of unconditional values")
        if len(factor.domain.values) < 2:
            self.check.fail("WMS503", f"`{name}` has no other level", span, "give it two values or more")

    # ------------------------------------------------------------ factors and what is read

    def _factor(self, name: str, span: Span) -> ir.Factor:
        if name not in self.factors:
            declared = self.check.scope.names.get(name)
            if isinstance(declared, s.Factor) and not declared.nuisance:
                raise Failed  # its error was reported
            self.check.unknown(s.Name(name, span), f"there is no factor `{name}`", suggestion(name, self.factors))
        return self.factors[name]

    def _values(self, name: str) -> tuple[ir.Level, ...]:
        domain = self.factors[name].domain
        assert isinstance(domain, ir.Choices)
        return domain.values

    def _refs(self, expr: ir.Expr) -> frozenset[str]:
        """Return the factors that a value depends on, directly or through `let`s."""
        return frozenset(part.name for part in reachable([expr], self.lets) if isinstance(part, ir.Ref))


def _otherwise(factors: Mapping[str, ir.Factor], levels: dict[str, ir.Level], place: Location) -> ir.Counterfactual:
    return ir.Counterfactual(
        name="_".join(_slug(factors[name], level) for name, level in levels.items()),
        change="levels",
        owner="",
        property="",
        value=None,
        sort="",
        levels=levels,
        place=place,
    )


def level_words(factor: ir.Factor, level: ir.Level) -> str:
    """Return a level in words: its label or its value."""
    called = factor.called(level)
    if called is not None:
        return called
    match level:
        case bool():
            return "yes" if level else "no"
        case float():
            return units.format_quantity(level, units.parse_unit(factor.unit)[1])
        case tuple():
            return f"({', '.join(level_words(factor, x) for x in level)})"
        case _:
            return level.replace("_", " ")


def _slug(factor: ir.Factor, level: ir.Level) -> str:
    """Return an identifier of a level, such as `full_of_sand` or `pace_55_cm_s`."""
    words = level_words(factor, level).replace("-", "minus ").replace(".", "p")
    name = re.sub(r"\W+", "_", words).strip("_")
    return name if name[:1].isalpha() and not isinstance(level, bool) else f"{factor.name}_{name}"


def _constant(level: ir.Level) -> ir.Expr:
    if isinstance(level, tuple):
        return ir.Items(items=tuple(ir.Value(value=x) for x in level))
    return ir.Value(value=level)
