"""Checks actions: verb, acting robot, arguments and timings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

from wmspec.core.diagnostics import suggestion
from wmspec.core.places import Span
from wmspec.lang.check.expressions.typed import Failed, Typed
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.verbs import OBJECT_VERBS, ROBOTS, VERB_ALIASES, VERBS, Verb
from wmspec.lang.check.tables.vocabulary import PropertySpec
from wmspec.lang.check.types.types import A_LENGTH, A_TIME, ACTION, AN_ANGLE, DIRECTION, OBJECT, ROBOT, Type
from wmspec.lang.parse import syntax as s

if TYPE_CHECKING:
    from wmspec.lang.check.expressions.expressions import Expressions

#: The timings of an action, as properties.
START = PropertySpec((A_TIME,), "when it starts", "0 s", least=0)
DURATION = PropertySpec((A_TIME,), "how long it lasts", least=0)


@dataclass(frozen=True)
class ResolvedAction:
    """A resolved action: its verb by name and table row, its robot (empty for verbs of objects), and the call."""

    name: str
    verb: Verb
    robot: str
    call: s.Call

    @property
    def slots(self) -> dict[str, PropertySpec]:
        """Arguments and timings, which counterfactuals can change."""
        timings = {"start": START} | ({"duration": DURATION} if self.verb.lasts else {})
        return self.verb.arguments | timings

    @property
    def assigned(self) -> list[tuple[str, s.Argument]]:
        """Every argument with its parameter name, empty if the verb has no such parameter."""
        names = list(self.verb.arguments)
        arguments = []
        for i, argument in enumerate(self.call.arguments):
            name = argument.name.id if argument.name else names[i] if i < len(names) else ""
            arguments.append((name if name in names else "", argument))
        return arguments

    @property
    def has_unknown_property(self) -> bool:
        """Whether an argument is unknown to the verb: it may be a misspelled one."""
        return any(not name for name, _ in self.assigned)

    @property
    def written(self) -> dict[str, s.Argument]:
        """The arguments by name; of duplicates the first."""
        return {name: argument for name, argument in reversed(self.assigned) if name}


def resolve_action(check: Expressions, action: s.Action) -> ResolvedAction:
    """Return the resolved action, or report an error."""
    call = action.call
    if isinstance(call, s.Operation) and call.operator == "if":
        _fail_conditional(check, action, call)
    if not isinstance(call, s.Call) or not isinstance(call.function, s.Name | s.Member):
        check.fail("WMS204", "an action is a verb with its arguments", call.span, "write `launch(ball, ...)`")
    if isinstance(call.function, s.Member):
        return _resolve_robot_verb(check, call, call.function)
    name = call.function.id
    if name not in VERBS:
        able = [f"{'an' if model[0] in 'aeiou' else 'a'} {model}" for model, verbs in ROBOTS.items() if name in verbs]
        hint = f"did you mean `{VERB_ALIASES[name]}`?" if name in VERB_ALIASES else suggestion(name, VERBS)
        if able:
            hint = f"robots can: `ROBOT.{name}(...)` of {' or '.join(able)}"
            hint += f"; nobody is needed for `{OBJECT_VERBS[name]}(...)`" if name in OBJECT_VERBS else ""
        check.fail("WMS204", f"there is no verb `{name}`", call.function.span, hint)
    return ResolvedAction(name, VERBS[name], "", call)


def _fail_conditional(check: Expressions, action: s.Action, call: s.Operation) -> NoReturn:
    """Report an action written as a choice between verbs."""
    condition, verb, other = (operand.span.text for operand in call.operands)
    remedy = f"write `action {action.name.id} = {verb} when {condition}`"
    if isinstance(call.operands[2], s.Call):
        remedy += f", and another action `{other} when not ({condition})`"
    check.fail("WMS204", "a condition follows the verb", call.span, remedy)


def _resolve_robot_verb(check: Expressions, call: s.Call, function: s.Member) -> ResolvedAction:
    """Resolve a robot's verb."""
    who = check.infer(function.value, (ROBOT,))
    if who.type == OBJECT and function.name.id in VERBS:
        known = (x for x in call.arguments if x.name is None or x.name.id in VERBS[function.name.id].arguments)
        remedy = f"write `{function.name.id}({', '.join(x.span.text for x in (function.value, *known))})`"
        check.fail("WMS204", "only robots have verbs, and this is an object", function.span, remedy)
    who = check.value(function.value, (ROBOT,), "the actor")
    if not isinstance(who.expr, ir.Value):
        remedy = "write an action for each robot; its arguments and times may depend on factors"
        check.fail("WMS302", "the acting robot must be constant", function.value.span, remedy)
    robot = check.scope.names[str(who.expr.value)]
    assert isinstance(robot, s.Block)
    if robot.model is None or robot.model.id not in ROBOTS:  # already reported
        raise Failed
    verbs = ROBOTS[robot.model.id]
    name = function.name.id
    if name not in verbs:
        message = f"`{robot.name.id}` has no verb `{name}`"
        check.fail("WMS204", message, function.name.span, suggestion(name, verbs))
    return ResolvedAction(name, verbs[name], robot.name.id, call)


def named(check: Expressions, name: str) -> s.Action:
    """Return the action of this name."""
    action = check.scope.names[name]
    assert isinstance(action, s.Action)
    return action


def property_(check: Expressions, name: str, member: s.Name) -> Typed:
    """Return `push.speed`, an argument or timing of an action, as a value."""
    action = named(check, name)
    slot = slot_of(check, name, member)
    expr = ir.Property(owner=ir.Value(value=name), name=member.id)
    does = resolve_action(check, action)
    if member.id in ("start", "duration"):
        return Typed(expr, A_TIME)
    if member.id not in does.written:
        if slot.default is None and does.has_unknown_property:
            raise Failed
        if slot.default is None:
            check.fail("WMS206", f"`{name}` has no {member.id}", member.span, f"add `{member.id}:` to it")
        return Typed(expr, slot.types[0])
    kind = argument(check, action, does, member.id).type
    if kind == DIRECTION and AN_ANGLE in slot.types:
        return Typed(ir.Call(function="heading_of", arguments=(expr,)), AN_ANGLE)
    return Typed(expr, kind)


def slot_of(check: Expressions, name: str, member: s.Name) -> PropertySpec:
    """Return the table row of an action's argument or timing, or report an error."""
    does = resolve_action(check, named(check, name))
    if member.id not in does.slots:
        if member.id == "duration":
            check.fail("WMS203", f"`{does.name}` is instantaneous and has no duration", member.span)
        hint = suggestion(member.id, does.slots)
        check.fail("WMS203", f"`{does.name}` has no property `{member.id}`", member.span, hint)
    return does.slots[member.id]


def argument(check: Expressions, action: s.Action, does: ResolvedAction, name: str) -> Typed:
    """Return the value of a written argument."""
    written = does.written[name]
    slot = does.verb.arguments[name]

    def make() -> Typed:
        check.subject = subject(check, action, does) if name != "object" else None
        return check.value(written.value, _types(check, action, does, name, slot), f"`{name}`")

    return check.memoized((action.name.id, name), written.span, make)


def subject(check: Expressions, action: s.Action, does: ResolvedAction) -> ir.Expr | None:
    """Return the object that an action moves, the origin of `toward`."""
    return argument(check, action, does, "object").expr if "object" in does.written else None


def _types(
    check: Expressions, action: s.Action, does: ResolvedAction, name: str, slot: PropertySpec
) -> tuple[Type, ...]:
    """Return the types that an argument accepts; the amount of a joint's motion depends on the joint."""
    if name not in ("target", "far") or "joint" not in does.written:
        return slot.types
    joint = argument(check, action, does, "joint").expr
    block = check.scope.names[str(joint.value)] if isinstance(joint, ir.Value) else None
    if not isinstance(block, s.Block) or block.model is None:
        return slot.types
    return {"hinge": (AN_ANGLE,), "slider": (A_LENGTH,)}.get(block.model.id, slot.types)


def start(check: Expressions, action: s.Action) -> tuple[Typed, Span]:
    """Return the start of an action and its source: `at` a time, `after` an action's end, `with` its start."""
    timing = next((t for t in reversed(action.timings) if t.kind not in ("for", "when")), None)
    if timing is None:
        return Typed(ir.Value(value=0.0), A_TIME), action.name.span
    span = timing.value.span
    if timing.kind == "at":
        return check.value(timing.value, (A_TIME,), "`at`"), span
    return check.memoized((action.name.id, timing.kind), span, lambda: _relative(check, timing)), span


def _relative(check: Expressions, timing: s.Timing) -> Typed:
    """Return the start of an action that is timed by another."""
    other = check.value(timing.value, (ACTION,), f"`{timing.kind}`").expr
    if not isinstance(other, ir.Value):
        check.fail("WMS302", "the action must be constant", timing.value.span)
    begin = ir.Property(owner=other, name="start")
    declared = named(check, str(other.value))
    start(check, declared)  # detects cycles
    if timing.kind == "with" or not resolve_action(check, declared).verb.lasts:
        return Typed(begin, A_TIME)
    duration = ir.Property(owner=other, name="duration")
    return Typed(ir.Operation(operator="+", operands=(begin, duration)), A_TIME)
