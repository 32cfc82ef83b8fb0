"""Checking what is there and what is done to it: objects, cameras, lights, the world, actions."""

from __future__ import annotations

from functools import cache

from wmspec.check import ir
from wmspec.check.expressions import Expressions, Failed, constant
from wmspec.check.kinds import A_TIME, ACTION, article
from wmspec.check.scope import Scope
from wmspec.check.verbs import VERBS
from wmspec.check.vocabulary import PROPERTIES, Slot
from wmspec.errors import suggestion
from wmspec.parse import syntax as s
from wmspec.parse.diagnostics import Note, Report
from wmspec.parse.parser import parse_expression
from wmspec.parse.source import Source, Span


class Things:
    """Checks blocks and actions; a mistake in one property is reported and the others are still looked at."""

    def __init__(self, check: Expressions) -> None:
        self.check = check
        self.scope = check.scope
        self.report = check.report

    def block(self, block: s.Block) -> ir.Thing:
        """An object, camera, light or the world, with the defaults of what is not written."""
        table = PROPERTIES[block.kind]
        properties: dict[str, ir.Setting] = {}
        spans: dict[str, Span] = {}
        for p in block.properties:
            if p.name.id in spans:
                notes = (Note("set here first", spans[p.name.id]),)
                self.report.add("WMS202", f"`{p.name.id}` is set twice", p.name.span, "remove one", notes)
                continue
            spans[p.name.id] = p.name.span
            try:
                properties |= self.property(block, p, table)
            except Failed:
                continue
        for name, slot in table.items():
            if name not in properties and name not in spans:
                if slot.default is not None:
                    properties[name] = self.default(slot, block.name.span)
                elif not slot.optional:
                    self.report.add(
                        "WMS206", f"the {block.kind} `{block.name.id}` needs `{name}`: {slot.meaning}", block.name.span
                    )
        kind = block.kind
        assert kind in ("object", "camera", "light", "world")
        return ir.Thing(kind=kind, name=block.name.id, properties=properties, place=ir.Place.of(block.name.span))

    def property(self, block: s.Block, p: s.Property, table: dict[str, Slot]) -> dict[str, ir.Setting]:
        """A written property, and where it is placed with `at`."""
        slot = self.check.slot(table, p.name, f"{article(block.kind)}")
        if p.at is not None and p.name.id != "on":
            self.check.fail("WMS101", "`at` follows `on:` only", p.at.span, "write `at: (x, y, z)`")
        typed = self.check.setting(block, p, slot)
        self.bounds(typed.expr, slot, p.value.span, f"`{p.name.id}`")
        found = {p.name.id: ir.Setting(value=typed.expr, place=ir.Place.of(p.value.span))}
        if p.at is not None:
            at = self.check.value(p.at, table["at"].kinds, "`at`")
            found["at"] = ir.Setting(value=at.expr, place=ir.Place.of(p.at.span))
        return found

    def default(self, slot: Slot, span: Span) -> ir.Setting:
        """The value of a property that is left out."""
        return ir.Setting(value=default_value(slot), place=ir.Place.of(span))

    def bounds(self, expr: ir.Expr, slot: Slot, span: Span, what: str) -> None:
        """Complain about a constant outside its bounds."""
        value = constant(expr)
        if value is not None and (reason := slot.fault(value)):
            self.check.fail("WMS304", f"{what} must be {reason}", span)

    # ------------------------------------------------------------ actions

    def action(self, action: s.Action) -> ir.Thing:
        """An action: its verb, arguments and timings."""
        verb = self.check.verb(action)
        assert isinstance(action.call, s.Call)
        table = VERBS[verb].arguments
        written = self.arguments(action.call, table, verb)
        properties: dict[str, ir.Setting] = {}
        self.check.subject = None
        for name, slot in table.items():
            if name not in written:
                if slot.default is None:
                    self.report.add("WMS205", f"`{verb}` needs `{name}`: {slot.meaning}", action.call.span)
                    continue
                properties[name] = self.default(slot, action.name.span)
                continue
            try:
                typed = self.check.value(written[name].value, slot.kinds, f"`{name}`")
                self.bounds(typed.expr, slot, written[name].value.span, f"`{name}`")
            except Failed:
                continue
            properties[name] = ir.Setting(value=typed.expr, place=ir.Place.of(written[name].value.span))
            if name == "object":
                self.check.subject = typed.expr
        self.check.subject = None
        properties |= self.timings(action, verb)
        return ir.Thing(
            kind="action", name=action.name.id, verb=verb, properties=properties, place=ir.Place.of(action.name.span)
        )

    def arguments(self, call: s.Call, table: dict[str, Slot], verb: str) -> dict[str, s.Argument]:
        """The written arguments of a verb by name."""
        found: dict[str, s.Argument] = {}
        names = list(table)
        for i, argument in enumerate(call.arguments):
            name = argument.name.id if argument.name else names[i] if i < len(names) else ""
            if name not in table:
                shown, span = (
                    (argument.name.id, argument.name.span) if argument.name else (argument.span.text, argument.span)
                )
                self.report.add("WMS205", f"`{verb}` has no argument `{shown}`", span, suggestion(shown, table))
            elif name in found:
                self.report.add("WMS205", f"`{name}` is given twice", argument.span, "remove one")
            else:
                found[name] = argument
        return found

    def timings(self, action: s.Action, verb: str) -> dict[str, ir.Setting]:
        """When an action starts and how long it lasts, from `at`, `for`, `after` and `with`."""
        start = ir.Setting(value=ir.Value(value=0.0), place=ir.Place.of(action.name.span))
        duration = None
        for timing in action.timings:
            where = ir.Place.of(timing.value.span)
            if timing.kind in ("after", "with"):
                start = ir.Setting(value=self.relative(timing), place=where)
            else:
                typed = self.check.value(timing.value, (A_TIME,), f"`{timing.kind}`")
                self.bounds(typed.expr, Slot((A_TIME,), "", least=0), timing.value.span, f"`{timing.kind}`")
                if timing.kind == "at":
                    start = ir.Setting(value=typed.expr, place=where)
                else:
                    duration = ir.Setting(value=typed.expr, place=where)
        if VERBS[verb].lasts and duration is None:
            self.check.fail(
                "WMS205", f"`{verb}` needs to know how long: `for TIME`", action.call.span, "add for instance `for 2 s`"
            )
        if not VERBS[verb].lasts and duration is not None:
            self.check.fail("WMS205", f"`{verb}` happens at once and cannot last", action.call.span, "remove `for`")
        return {"start": start} | ({"duration": duration} if duration else {})

    def relative(self, timing: s.Timing) -> ir.Expr:
        """The start of an action that is timed by another."""
        other = self.check.value(timing.value, (ACTION,), f"`{timing.kind}`")
        assert isinstance(other.expr, ir.Value)
        start = ir.Property(owner=other.expr, name="start")
        if timing.kind == "with":
            return start
        declared = self.scope.names[str(other.expr.value)]
        assert isinstance(declared, s.Action)
        if not VERBS[self.check.verb(declared)].lasts:
            return start
        return ir.Operation(operator="+", operands=(start, ir.Property(owner=other.expr, name="duration")))


@cache
def default_value(slot: Slot) -> ir.Expr:
    """The value that a property or argument has when it is left out."""
    assert slot.default is not None
    source = Source("<default>", slot.default)
    report = Report()
    expr = parse_expression(Span(source, 0, len(slot.default)), report)
    assert expr is not None, slot
    return Expressions(Scope((), report), report).value(expr, slot.kinds, "the default").expr
