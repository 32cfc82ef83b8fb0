"""Checks counterfactuals: each has exactly one change."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import cast

from wmspec.core.diagnostics import Note
from wmspec.core.places import Location
from wmspec.lang.check.expressions import actions
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.members import named
from wmspec.lang.check.expressions.typed import Typed, constant
from wmspec.lang.check.ir import ir
from wmspec.lang.check.library.files import resolve_path
from wmspec.lang.check.statements.factors import Factors
from wmspec.lang.check.statements.objects import Entities
from wmspec.lang.check.tables.vocabulary import FILES, PropertySpec
from wmspec.lang.check.types.types import ACTION, CAMERA, JOINT, LIGHT, OBJECT, PART, ROBOT, WORLD, List, article
from wmspec.lang.parse import syntax as s

#: Types with properties that a counterfactual can change.
_CHANGEABLE = (OBJECT, PART, CAMERA, LIGHT, JOINT, ROBOT, WORLD)


class Counterfactuals:
    """Checks the counterfactuals of a task; an error is reported and raises `Failed`."""

    def __init__(self, check: Expressions, things: Entities, factors: Factors) -> None:
        self.check = check
        self.things = things
        self.factors = factors
        self.added: list[ir.Entity] = []
        """The actions that counterfactuals add."""
        self._what_ifs: dict[str, ir.Counterfactual] = {}
        check.change_of = self.what_if

    def counterfactual(self, written: s.Counterfactual) -> ir.Counterfactual:
        """Return a counterfactual with its one change."""
        name = written.name.id
        if len(written.changes) != 1:
            many = len(written.changes)
            what = f"a counterfactual changes exactly one thing, but `{name}` changes {many}"
            remedy = "make one counterfactual of each change" if many else "write the change"
            self.check.fail("WMS503", what, written.name.span, remedy)
        return self._change(name, written.changes[0])

    def what_if(self, change: s.Change) -> ir.Counterfactual:
        """Return the change of a what-if, named by its own words; two of the same words are one."""
        words = f"{change.kind} {change.span.words}"
        if words not in self._what_ifs:
            taken = {made.name for made in self._what_ifs.values()}
            self._what_ifs[words] = self._change(_unique(_slug(change), taken), change)
        return self._what_ifs[words]

    def _change(self, name: str, change: s.Change) -> ir.Counterfactual:
        match change.kind:
            case "without":
                return self._without(name, change)
            case "level":
                return self._level(name, change)
            case "order":
                return self._order(name, change)
            case "add":
                return self._added(name, change)
            case _:
                return self._changed(name, change)

    def _made(
        self, name: str, change: s.Change, owner: str, prop: str, value: ir.Expr | None, sort: str
    ) -> ir.Counterfactual:
        return ir.Counterfactual(
            name=name,
            change=cast(ir.Change, "levels" if change.kind == "level" else change.kind),
            owner=owner,
            property=prop,
            value=value,
            sort=sort,
            place=Location.of(change.span),
        )

    def _without(self, name: str, change: s.Change) -> ir.Counterfactual:
        """Leave out an object or an action; which one may depend on factors."""
        typed = self.check.infer(change.target, (ACTION, OBJECT))
        if typed.type in (List(ACTION), List(OBJECT)):
            what = f"`without` leaves out one thing, and `{change.target.span.text}` is a set"
            remedy = "let a factor decide whether its members are there (`present:`, `when`), and change its level"
            self.check.fail("WMS503", what, change.target.span, remedy)
        removed = self.check.value(change.target, (ACTION, OBJECT), "`without`").expr
        if isinstance(removed, ir.Value):
            return self._made(name, change, str(removed.value), "", None, "")
        return self._made(name, change, "", "", removed, "")

    def _level(self, name: str, change: s.Change) -> ir.Counterfactual:
        """Set another level of a factor."""
        assert isinstance(change.target, s.Name)
        assert change.value is not None
        factor = self.factors.declared(change.target.id, change.target.span)
        level = self.factors.level(factor, change.value)
        return replace(self._made(name, change, "", "", None, ""), levels={factor.name.id: level})

    def _action(self, e: s.Expr, what: str) -> str:
        """Return the name of an action."""
        expr = self.check.value(e, (ACTION,), what).expr
        if not isinstance(expr, ir.Value):
            self.check.fail("WMS503", f"{what} names an action", e.span, "the action must be constant")
        return str(expr.value)

    def _added(self, name: str, change: s.Change) -> ir.Counterfactual:
        """Add an action, named like the counterfactual."""
        written = s.Action(s.Name(name, change.target.span), change.target, change.timings, change.span)
        if name in self.check.scope.names:
            notes = (Note("declared here", self.check.scope.names[name].name.span),)
            what = f"the added action is named `{name}`, and that name is declared already"
            self.check.fail("WMS202", what, change.span, "give the counterfactual another name", notes)
        self.check.scope.names[name] = written
        self.added.append(replace(self.things.action(written), added=True))
        return self._made(name, change, name, "", None, "")

    # ------------------------------------------------------------ the order of two actions

    def _order(self, name: str, change: s.Change) -> ir.Counterfactual:
        assert change.value is not None
        first, second = self._action(change.target, "`order`"), self._action(change.value, "`order`")
        if first == second:
            message = "an action cannot swap its order with itself"
            self.check.fail("WMS503", message, change.value.span, "name two actions")
        if self._turn(first) == self._turn(second) is not None:
            message = f"`{first}` and `{second}` begin and end together, so their order makes no difference"
            self.check.fail("WMS503", message, change.span, "let one begin `after` the other")
        return self._made(name, change, first, second, None, "")

    def _turn(self, name: str) -> tuple[float, float] | None:
        """Return the start and duration of an action if both are constant."""
        action = actions.named(self.check, name)
        start = self._start(action)
        timing = next((t for t in action.timings if t.kind == "for"), None)
        duration = constant(self.check.infer(timing.value).expr) if timing is not None else 0.0
        return None if start is None or duration is None else (start, duration)

    def _start(self, action: s.Action) -> float | None:
        """Return the constant start of an action; with `with`, that of the other action."""
        expr = actions.start(self.check, action)[0].expr
        if isinstance(expr, ir.Property) and isinstance(expr.owner, ir.Value):
            return self._start(actions.named(self.check, str(expr.owner.value)))
        return constant(expr)

    # ------------------------------------------------------------ an argument or a property

    def _changed(self, name: str, change: s.Change) -> ir.Counterfactual:
        assert change.value is not None
        owner, prop, slot = self._target(change)
        typed = self._value(change, change.value, owner, slot, prop)
        self.check.bounds(typed.expr, slot, change.value.span, f"`{prop}`")
        expr = resolve_path(self.check, prop, change.value, typed.expr) if prop in FILES else typed.expr
        own = ir.Property(owner=ir.Value(value=owner), name=prop)
        if expr in (own, ir.Call(function="heading_of", arguments=(own,))):
            self.check.fail(
                "WMS503", "this is the value without the counterfactual", change.value.span, "change the value"
            )
        return self._made(name, change, owner, prop, expr, str(typed.type))

    def _value(self, change: s.Change, value: s.Expr, owner: str, slot: PropertySpec, prop: str) -> Typed:
        if change.kind == "action":
            action = actions.named(self.check, owner)
            self.check.subject = actions.subject(self.check, action, actions.resolve_action(self.check, action))
        try:
            return self.check.value(value, slot.types, f"`{prop}`")
        finally:
            self.check.subject = None

    def _target(self, change: s.Change) -> tuple[str, str, PropertySpec]:
        """Return the target of a change: its owner, its name and its slot."""
        target = change.target
        example = "push.speed" if change.kind == "action" else "ball.mass"
        if not isinstance(target, s.Member):
            message = f"`{change.kind}` changes one named value"
            self.check.fail("WMS503", message, target.span, f"write something like `{example}`")
        owner = self.check.infer(target.value)
        expected = (ACTION,) if change.kind == "action" else _CHANGEABLE
        if owner.type not in expected or not isinstance(owner.expr, ir.Value):
            what = "an action" if change.kind == "action" else "an object or camera"
            actual = article(str(owner.type))
            message = f"`{change.kind}` changes {what}, but this is {actual}"
            if owner.type in expected:
                message = f"`{change.kind}` changes one named value, and which {owner.type} this is depends on a factor"
            self.check.fail("WMS503", message, target.value.span)
        name, prop = str(owner.expr.value), target.name
        if owner.type == ACTION:
            return name, prop.id, actions.slot_of(self.check, name, prop)
        of = named(self.check, name)
        if prop.id not in of.slots:
            self.check.fail(*of.unknown_property_error(prop))
        return name, prop.id, of.slots[prop.id]


def _slug(change: s.Change) -> str:
    """Return the words of a change as a name, such as `without_green` or `state_ball_mass_2_kg`."""
    words = re.sub(r"-", " minus ", re.sub(r"\+", " plus ", change.span.words))
    name = re.sub(r"\W+", "_", words).strip("_")
    return f"without_{name}" if change.kind == "without" else name


def _unique(name: str, taken: set[str]) -> str:
    """Return the name, numbered if it is taken."""
    return next(n for n in (name, *(f"{name}_{k}" for k in range(2, len(taken) + 3))) if n not in taken)
