"""Checks members: properties, action arguments, parts, coordinates of points, members of sets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NoReturn

from wmspec.core.diagnostics import suggestion
from wmspec.core.places import Span
from wmspec.lang.check.expressions import actions
from wmspec.lang.check.expressions.names import BLOCKS, may_be_undeclared_name, present
from wmspec.lang.check.expressions.owners import Owner, owner, part_owners
from wmspec.lang.check.expressions.typed import Failed, Typed, constant
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.tables.vocabulary import BY_MATERIAL, PROPERTIES, SETS, PropertySpec
from wmspec.lang.check.types.types import (
    A_NUMBER,
    ACTION,
    JOINT,
    OBJECT,
    PART,
    List,
    Quantity,
    Type,
    Vector,
    article,
)
from wmspec.lang.parse import syntax as s

if TYPE_CHECKING:
    from wmspec.lang.check.expressions.expressions import Expressions

#: Types that have properties.
_OWNERS = {**{kind: block for block, kind in BLOCKS.items()}, PART: "part"}


def member(check: Expressions, e: s.Member) -> Typed:
    """Check `ball.mass`, `push.speed`, `rack.left`, `spot.x`."""
    whole = check.infer(e.value, tuple(_OWNERS))
    point = whole.type.item if isinstance(whole.type, List) else whole.type
    if isinstance(point, Vector):
        return _coordinate(check, whole, point, e.name)
    if whole.type == ACTION and isinstance(whole.expr, ir.Value):
        return actions.property_(check, str(whole.expr.value), e.name)
    if whole.type not in _OWNERS:
        if may_be_undeclared_name(check, e.value, whole.type):
            check.type_mismatch(e.value, whole.type, (OBJECT,), f"`.{e.name.id}`")
        check.fail("WMS203", f"{article(str(whole.type))} has no properties", e.name.span)
    kind = _OWNERS[whole.type]
    if not isinstance(whole.expr, ir.Value):  # depends on a factor
        slot = _row(check, PROPERTIES[kind], e, kind)
        return Typed(ir.Property(owner=whole.expr, name=e.name.id), slot.types[0])
    name = str(whole.expr.value)
    if (of_asset := _of_asset(check, name, e.name)) is not None:
        return of_asset
    if whole.type == OBJECT and f"{name}.{e.name.id}" in _parts(check, name):
        return Typed(ir.Value(value=f"{name}.{e.name.id}"), PART)
    return Typed(ir.Property(owner=whole.expr, name=e.name.id), _type(check, named(check, name), e))


def _of_asset(check: Expressions, name: str, member: s.Name) -> Typed | None:
    """Return a link or joint of an asset, or None."""
    if name in check.scope.broken:  # its contents are unknown
        raise Failed
    block = check.scope.assets.get(name, {}).get(member.id)
    if block is None:
        return None
    declared = check.scope.names[block]
    assert isinstance(declared, s.Block)
    return Typed(ir.Value(value=block), BLOCKS[declared.kind])


def named(check: Expressions, name: str) -> Owner:
    """Return the block or part of this IR name."""
    whole, dot, _ = name.partition(".")
    if dot:
        return _parts(check, whole)[name]
    block = check.scope.names[name]
    assert isinstance(block, s.Block)
    return owner(block, check.scope.assets.get(name, {}))


def _parts(check: Expressions, name: str) -> dict[str, Owner]:
    block = check.scope.names[name]
    assert isinstance(block, s.Block)
    return {part.name: part for part in part_owners(block)}


def _row(check: Expressions, table: dict[str, PropertySpec], e: s.Member, what: str) -> PropertySpec:
    name = e.name
    if name.id not in table:
        message = f"{article(what)} has no property `{name.id}`"
        check.fail("WMS203", message, name.span, _measure(check, e, what) or suggestion(name.id, table))
    return table[name.id]


def _measure(check: Expressions, e: s.Member, what: str) -> str:
    """Return the remedy for a measure or coordinate written as a property, or ''."""
    name, of = e.name.id, e.value.span.text
    if what == "object" and name in ("x", "y", "z"):
        return f"write `position({of}).{name}`" if check.measured else f"write `{of}.at.{name}`"
    function = FUNCTIONS.get(name)
    fits = function is not None and function.parameters == ({"object": OBJECT, "joint": JOINT}.get(what),)
    return f"write `{name}({of})`" if function and fits and (check.measured or not function.measured) else ""


def _coordinate(check: Expressions, point: Typed, kind: Vector, name: s.Name) -> Typed:
    """Return a coordinate of a point, or of each point of a list."""
    axes = "xyz"[: kind.size]
    if name.id not in axes or len(name.id) != 1:
        check.fail("WMS203", f"{article(str(kind))} has no `{name.id}`", name.span, f"it has {', '.join(axes)}")
    each = 0 if isinstance(point.type, List) else None
    one = Quantity(kind.dimension)
    expr = ir.Operation(operator=name.id, operands=(point.expr,), each=each)
    return Typed(expr, one if each is None else List(one))


def _type(check: Expressions, of: Owner, e: s.Member) -> Type:
    """Return the type of a property: that of its value or default."""
    name = e.name
    if name.id not in of.slots:
        code, message, span, help = of.unknown_property_error(name)
        check.fail(code, message, span, _measure(check, e, of.type.kind) or help)
    slot = of.slots[name.id]
    if name.id in of.set_properties:
        return setting(check, of, of.set_properties[name.id], slot).type
    if slot.default is None and name.id not in BY_MATERIAL:
        if of.has_unknown_property:
            raise Failed
        check.fail(*of.missing_value_error(name))
    return slot.types[0]


def setting(check: Expressions, of: Owner, p: s.Property, slot: PropertySpec) -> Typed:
    """Return the value of a written property."""
    key = (of.name, p.name.id)
    return check.memoized(key, p.name.span, lambda: check.value(p.value, slot.types, f"`{p.name.id}`"))


def index(check: Expressions, e: s.Index) -> Typed:
    """Check `blocks[2]`, a member of a set; `blocks[-1]` is the last present one."""
    declared = check.scope.names.get(e.value.id) if isinstance(e.value, s.Name) else None
    if not isinstance(declared, s.Block | s.Action | s.Factor) or declared.count is None:
        _fail_no_set(check, e, declared)
    members = check.scope.members(declared.name.id)
    if not members:  # its wrong count was reported
        raise Failed
    written = check.value(e.index, (A_NUMBER,), "`[...]`").expr
    number = constant(written)
    if number is None:
        return _varying_member(check, e, declared, members, written)
    if number != int(number) or not -len(members) <= number < len(members):
        message = f"`{declared.name.id}` has members 0 to {len(members) - 1}"
        check.fail("WMS304", message, e.index.span, "count from the end with `-1`, the last that is there")
    if isinstance(declared, s.Block):
        if number >= 0:
            return Typed(ir.Value(value=members[int(number)]), BLOCKS[SETS[declared.kind]])
        last = ir.Call(function="nth", arguments=(present(members), ir.Value(value=number)))
        return Typed(last, BLOCKS[SETS[declared.kind]])
    if number < 0 and _varies(check, declared):
        message = f"how many members `{declared.name.id}` has depends on a factor, so its last one does too"
        check.fail("WMS304", message, e.index.span, "count from the start, from 0 on")
    return _member(check, declared, members[int(number)], e.span)


def _varying_member(
    check: Expressions, e: s.Index, declared: s.Block | s.Action | s.Factor, members: Sequence[str], number: ir.Expr
) -> Typed:
    """Return the member at an index that depends on factors."""
    if isinstance(declared, s.Action):
        check.fail("WMS304", "the index of an action must be constant", e.index.span,
                   "let the arguments of one action depend on factors")  # fmt: skip
    if isinstance(declared, s.Block):
        typed = [Typed(ir.Value(value=name), BLOCKS[SETS[declared.kind]]) for name in members]
    else:
        typed = [_member(check, declared, name, e.span) for name in members]
    items = ir.Items(items=tuple(each.expr for each in typed))
    return Typed(ir.Call(function="member", arguments=(items, number)), typed[0].type)


def all_of(check: Expressions, e: s.Name, declared: s.Action | s.Factor) -> Typed:
    """Return the list of all members of a set of actions or nuisances, whose number must be constant."""
    members = check.scope.members(e.id)
    if not members:  # its wrong count was reported
        raise Failed
    if _varies(check, declared):
        message = f"how many members `{e.id}` has depends on a factor"
        check.fail("WMS302", message, e.span, f"name one member, as in `{e.id}[0]`, in a set `{e.id}[index]`")
    typed = [_member(check, declared, name, e.span) for name in members]
    return Typed(ir.Items(items=tuple(each.expr for each in typed)), List(typed[0].type))


def _member(check: Expressions, declared: s.Action | s.Factor, name: str, span: Span) -> Typed:
    """Return a member of a set of actions or nuisances."""
    if isinstance(declared, s.Action):
        return Typed(ir.Value(value=name), ACTION)
    return check.infer(s.Name(name, span))


def _varies(check: Expressions, declared: s.Action | s.Factor) -> bool:
    """Whether the number of members depends on a factor."""
    assert declared.count is not None
    return constant(check.value(declared.count, (A_NUMBER,), "the number of a set").expr) is None


def _fail_no_set(check: Expressions, e: s.Index, declared: object) -> NoReturn:
    """Report an index of something that is no set."""
    container = check.infer(e.value)
    what, remedy = article(str(container.type)), "declare it with `objects NAME[NUMBER] { ... }`"
    if isinstance(container.type, List):
        written = e.value.span.text
        remedy = f"write `pick({written}, {e.index.span.text})`"
    elif isinstance(declared, s.Action):
        remedy = "declare it with `actions NAME[NUMBER] = ...`"
    elif isinstance(declared, s.Factor) and declared.nuisance:
        remedy = "declare it with `nuisance NAME[NUMBER] in ...`"
    message = f"only a set of objects, joints, actions or nuisances has members, and this is {what}"
    check.fail("WMS302", message, e.value.span, remedy)
