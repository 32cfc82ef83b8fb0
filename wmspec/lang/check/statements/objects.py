"""Checks entities: objects and parts, cameras, lights, joints, robots, actions."""

from __future__ import annotations

import re
from typing import cast

from wmspec.core.diagnostics import Note, Remedy, suggestion
from wmspec.core.places import Location, Span
from wmspec.lang.check.expressions import actions
from wmspec.lang.check.expressions.actions import DURATION, START, ResolvedAction
from wmspec.lang.check.expressions.expressions import Expressions, default_value
from wmspec.lang.check.expressions.members import setting
from wmspec.lang.check.expressions.owners import Owner, owner, part_owners
from wmspec.lang.check.expressions.typed import Failed
from wmspec.lang.check.ir import ir
from wmspec.lang.check.library.files import possible_texts, resolve_path
from wmspec.lang.check.tables.property_schema import inherited_appearance
from wmspec.lang.check.tables.verbs import ROBOTS
from wmspec.lang.check.tables.vocabulary import COLORS, FILES, JOINTS, MEASURES, PROPERTIES, PropertySpec
from wmspec.lang.check.types.types import A_TIME, TRUTH, article, either
from wmspec.lang.parse import syntax as s
from wmspec.sim.shapes import SHAPES

_ARTICLE = re.compile(r"(the|an?)\b\s*", re.IGNORECASE)
_MODELS = {"joint": tuple(JOINTS), "robot": tuple(ROBOTS)}


class Entities:
    """Checks blocks and actions; an error in one property is reported and the others are still checked."""

    def __init__(self, check: Expressions) -> None:
        self.check = check
        self.scope = check.scope
        self.report = check.report
        self._reported: set[Span] = set()

    # ------------------------------------------------------------ blocks

    def block(self, block: s.Block) -> tuple[ir.Entity, ...]:
        """Return an entity with its defaults, followed by the parts of an object."""
        self._check_kind(block)
        of = owner(block)
        whole = ir.Entity(
            kind=cast(ir.EntityKind, block.kind),  # sets are already expanded
            name=of.name,
            model=block.model.id if block.model else "",
            of=block.whole,
            set=self.scope.sets.get(of.name, ""),
            properties=self._properties(of),
            place=Location.of(of.span),
        )
        if block.kind == "joint":
            self._check_joined(whole, block)
        return whole, *(self._part(whole, part) for part in part_owners(block))

    def _check_kind(self, block: s.Block) -> None:
        """Report a model or parts on a kind of block that has none."""
        kind, model = block.kind, block.model
        if block.parts and kind != "object":
            self.report.add("WMS405", f"{article(kind)} has no parts", block.parts[0].name.span, "only an object has")
        if kind in _MODELS and (model is None or model.id not in _MODELS[kind]):
            self._fail_once(model or block)
            known = ", ".join(_MODELS[kind])
            if model is None:
                name = self.scope.sets.get(block.name.id, block.name.id)
                message = f"the {kind} `{name}` has no kind"
                remedy = f"write `: KIND` after its name: {known}"
                self.check.fail("WMS206", message, block.name.span, remedy)
            message = f"there is no kind of {kind} `{model.id}`"
            self.check.fail("WMS201", message, model.span, suggestion(model.id, _MODELS[kind]))
        if kind not in ("object", *_MODELS) and model is not None:
            message = f"{article(kind)} has no template"
            self.report.add("WMS405", message, model.span, "only an object has")
        parts = ((part.name.id, part.name.span) for part in block.parts)
        self.report.add_repeated(parts, f"`{block.name.id}` has two parts `{{}}`")

    def _fail_once(self, written: s.Name | s.Block) -> None:
        """Fail silently if the error was reported for another member of the same set."""
        if written.span in self._reported:
            raise Failed
        self._reported.add(written.span)

    def _part(self, whole: ir.Entity, of: Owner) -> ir.Entity:
        """Return a part; it inherits unset appearance properties from its object."""
        properties = self._properties(of)
        for name in inherited_appearance(of.set_properties, whole.properties):
            value = ir.Property(owner=ir.Value(value=whole.name), name=name)
            properties[name] = ir.Setting(value=value, place=Location.of(of.span))
        place = Location.of(of.span)
        return ir.Entity(kind="part", name=of.name, of=whole.name, properties=properties, place=place)

    def _properties(self, of: Owner) -> dict[str, ir.Setting]:
        """Return the written properties and the defaults of the others."""
        properties: dict[str, ir.Setting] = {}
        spans: dict[str, Span] = {}
        here = Location.of(of.span)
        for p in of.written:
            for name, span in [(p.name.id, p.name.span)] + ([("at", p.at.span)] if p.at else []):
                if name in spans:
                    notes = (Note("set here first", spans[name]),)
                    self.report.add("WMS202", f"`{name}` is set twice", span, "remove one", notes)
                spans.setdefault(name, span)
            try:
                for name, made in self._written(of, p).items():
                    properties.setdefault(name, made)
            except Failed:
                continue
        for name, slot in of.slots.items():
            if name not in spans and slot.default is not None:
                properties[name] = ir.Setting(value=default_value(slot), place=here)
            elif name not in spans and not slot.optional and not of.has_unknown_property:
                message = f"the {of.type.kind} `{of.name}` needs `{name}`: {slot.meaning}"
                self.report.add("WMS206", message, of.span)
        self._report_ineffective(of, properties)
        return properties

    def _report_ineffective(self, of: Owner, properties: dict[str, ir.Setting]) -> None:
        """Report ineffective properties: `density` next to `mass`, and sizes that the shape lacks."""
        if (
            of.type.kind == "object"
            and not of.type.asset
            and "file" not in of.set_properties
            and {"mass", "density"} <= of.set_properties.keys()
        ):
            notes = (Note("its mass is set here", of.set_properties["mass"].span),)
            message = "`density` has no effect next to `mass`"
            self.report.add("WMS203", message, of.set_properties["density"].name.span, "remove one of them", notes)
        shape = properties["shape"].value if "shape" in properties else None
        for name in MEASURES:
            if name in of.set_properties and isinstance(shape, ir.Value) and not SHAPES[str(shape.value)].accepts(name):
                takes = [f"`{m}:`" for m in MEASURES if SHAPES[str(shape.value)].accepts(m)]
                takes = takes[:1] if takes[:1] == ["`size:`"] else takes
                remedy = f"set its size with {either(takes[:3])}"
                self.report.add("WMS203", f"a {shape.value} has no `{name}`", of.set_properties[name].name.span, remedy)

    def _written(self, of: Owner, p: s.Property) -> dict[str, ir.Setting]:
        """Return a written property, and its `at` if any."""
        if p.name.id not in of.slots:
            if (
                p.name.id in PROPERTIES[of.type.kind]
                and not of.set_properties.keys() <= PROPERTIES[of.type.kind].keys()
            ):
                raise Failed  # the required property may be misspelled
            self.check.fail(*of.unknown_property_error(p.name))
        if p.at is not None and p.name.id not in ("on", "inside"):
            remedy = "write `at: (x, y, z)`"
            self.check.fail("WMS101", "`at` follows `on:` and `inside:` only", p.at.span, remedy)
        settings = {p.name.id: self._setting(of, p)}
        if p.at is not None:
            at = s.Property(s.Name("at", p.at.span), p.at, None, p.span)
            settings["at"] = self._setting(of, at)
        return settings

    def _setting(self, of: Owner, p: s.Property) -> ir.Setting:
        name, slot = p.name.id, of.slots[p.name.id]
        typed = setting(self.check, of, p, slot)
        self.check.bounds(typed.expr, slot, p.value.span, f"`{name}`")
        if name in ("called", "plural"):
            self._check_noun(of, p)
        expr = resolve_path(self.check, name, p.value, typed.expr) if name in FILES else typed.expr
        return ir.Setting(value=expr, place=Location.of(p.value.span))

    def _check_noun(self, of: Owner, p: s.Property) -> None:
        """Report a name with an article or colour, as in `the blue crate`, and a name without letters."""
        for text in possible_texts(self.check, p.value, set()):
            noun = text.value.strip()
            before = _ARTICLE.match(noun)
            noun = noun[before.end() :] if before else noun
            color, _, rest = noun.partition(" ")
            noun = rest.strip() if rest and color in COLORS and "color" in of.set_properties else noun
            if not noun:
                self.check.fail("WMS304", f"`{p.name.id}` contains no name", text.span, 'write a noun, as in `"crate"`')
            if noun != text.value:
                remedy = Remedy.of(f'write `"{noun}"`', text.span.text, f'"{noun}"')
                what = f"texts put article and colour before what is said with `{p.name.id}`"
                self.check.fail("WMS304", what, text.span, remedy)

    def _check_joined(self, joint: ir.Entity, block: s.Block) -> None:
        of, to = joint.properties.get("of"), joint.properties.get("to")
        if of is not None and to is not None and of.value == to.value and isinstance(of.value, ir.Value):
            self.check.fail("WMS304", f"`{joint.name}` joins `{of.value.value}` to itself", block.name.span)

    # ------------------------------------------------------------ actions

    def action(self, action: s.Action) -> ir.Entity:
        """Return an action with its verb, arguments and timings."""
        does = actions.resolve_action(self.check, action)
        self._check_arguments(does)
        properties: dict[str, ir.Setting] = {}
        for name, slot in does.verb.arguments.items():
            if name in does.written:
                try:
                    properties[name] = self._argument(action, does, name, slot)
                except Failed:
                    continue
            elif slot.default is not None:
                properties[name] = ir.Setting(value=default_value(slot), place=Location.of(action.name.span))
            elif not slot.optional and not does.has_unknown_property:
                self.report.add("WMS205", f"`{does.name}` needs `{name}`: {slot.meaning}", does.call.span)
        if does.name == "drive" and not does.robot:
            self._check_drive(action, does)
        return ir.Entity(
            kind="action",
            name=action.name.id,
            verb=does.name,
            of=does.robot,
            set=self.scope.sets.get(action.name.id, ""),
            properties=properties | self._timings(action, does),
            place=Location.of(action.name.span),
        )

    def _argument(self, action: s.Action, does: ResolvedAction, name: str, slot: PropertySpec) -> ir.Setting:
        typed = actions.argument(self.check, action, does, name)
        span = does.written[name].value.span
        self.check.bounds(typed.expr, slot, span, f"`{name}`")
        return ir.Setting(value=typed.expr, place=Location.of(span))

    def _check_arguments(self, does: ResolvedAction) -> None:
        """Report unknown and duplicate arguments."""
        given: set[str] = set()
        for name, argument in does.assigned:
            if not name:
                named = argument.name or s.Name(argument.span.text, argument.span)
                hint = suggestion(named.id, does.verb.arguments)
                self.report.add("WMS205", f"`{does.name}` has no argument `{named.id}`", named.span, hint)
            elif name in given:
                self.report.add("WMS205", f"`{name}` is given twice", argument.span, "remove one")
            given.add(name)

    def _check_drive(self, action: s.Action, does: ResolvedAction) -> None:
        """Report a target for a joint without a drive."""
        joint = actions.argument(self.check, action, does, "joint").expr if "joint" in does.written else None
        block = self.scope.names.get(str(joint.value)) if isinstance(joint, ir.Value) else None
        if not isinstance(block, s.Block):
            return
        if "stiffness" not in owner(block).set_properties:
            message = f"nothing drives `{block.name.id}`: it has no stiffness"
            notes = (Note(f"`{block.name.id}` is declared here", block.name.span),)
            self.report.add("WMS206", message, does.call.span, "add `stiffness:` to the joint", notes)

    def _timings(self, action: s.Action, does: ResolvedAction) -> dict[str, ir.Setting]:
        """Return the start, duration and condition of an action, from `at`, `for`, `after`, `with` and `when`."""
        named = {"for": "how long this lasts", "when": "the condition of this"}
        timed = ((named.get(t.kind, "when this starts"), t.span) for t in action.timings)
        self.report.add_set_twice(timed, "{} is set twice")
        begin, span = actions.start(self.check, action)
        self.check.bounds(begin.expr, START, span, "`at`")
        settings = {"start": ir.Setting(value=begin.expr, place=Location.of(span))}
        lasting = next((t for t in action.timings if t.kind == "for"), None)
        if lasting is None and does.verb.lasts:
            message = f"`{does.name}` needs a duration: `for TIME`"
            self.check.fail("WMS205", message, does.call.span, "add for instance `for 2 s`")
        if lasting is not None:
            if not does.verb.lasts:
                message = f"`{does.name}` is instantaneous and has no duration"
                self.check.fail("WMS205", message, does.call.span, "remove `for`")
            typed = self.check.value(lasting.value, (A_TIME,), "`for`")
            self.check.bounds(typed.expr, DURATION, lasting.value.span, "`for`")
            settings["duration"] = ir.Setting(value=typed.expr, place=Location.of(lasting.value.span))
        if (when := next((t for t in action.timings if t.kind == "when"), None)) is not None:
            condition = self.check.value(when.value, (TRUTH,), "`when`").expr
            settings["when"] = ir.Setting(value=condition, place=Location.of(when.value.span))
        return settings
