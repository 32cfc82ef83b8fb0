"""Checking expressions: every name resolved, every unit turned to SI, every kind known."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn

from wmspec.check import ir, units
from wmspec.check.functions import FUNCTIONS
from wmspec.check.kinds import (
    A_NUMBER,
    A_TIME,
    ACTION,
    CAMERA,
    OBJECT,
    TEXT,
    TRUTH,
    Kind,
    List,
    Quantity,
    Vector,
    Word,
    article,
)
from wmspec.check.scope import Scope
from wmspec.check.units import NUMBER, Dimension
from wmspec.check.verbs import VERBS
from wmspec.check.vocabulary import BY_MATERIAL, PROPERTIES, WORDS, Slot
from wmspec.errors import suggestion
from wmspec.parse import syntax as s
from wmspec.parse.diagnostics import Note, Report
from wmspec.parse.source import Span

#: The dimension of a bare `0`, which fits wherever a quantity is wanted.
ZERO = Dimension(99, 99, 99, 99)


class Failed(Exception):
    """A mistake was reported; whoever asked for the value goes on without it."""


@dataclass(frozen=True)
class Typed:
    """A checked expression and its kind."""

    expr: ir.Expr
    kind: Kind


class Expressions:
    """Checks the expressions of one task. Declarations are checked when they are first needed, in any order."""

    def __init__(self, scope: Scope, report: Report) -> None:
        self.scope = scope
        self.report = report
        self.subject: ir.Expr | None = None  # the acting object, inside an action's arguments
        self.measured = False  # whether measured functions may stand here
        self.timings: dict[tuple[str, str], Typed] = {}
        self._known: dict[tuple[str, str], Typed | None] = {}
        self._open: list[tuple[tuple[str, str], Span]] = []
        self.domain_of: Callable[[s.Factor], Kind] = self.factor_kind

    # ------------------------------------------------------------ entry points

    def value(self, e: s.Expr, wanted: tuple[Kind, ...], what: str) -> Typed:
        """Check an expression that must be of one of the wanted kinds. `what` names the place in messages."""
        typed = self.infer(e, wanted)
        for kind in wanted:
            if fits(typed.kind, kind):
                return Typed(typed.expr, kind)
        self.misfit(e.span, typed.kind, wanted, what)

    def infer(self, e: s.Expr, wanted: tuple[Kind, ...] = ()) -> Typed:
        """Check an expression of any kind; `wanted` helps to read bare words and suggest others."""
        match e:
            case s.Number():
                return self._number(e.value, e.unit, e.span)
            case s.Text():
                return Typed(ir.Value(value=e.value), TEXT)
            case s.Truth():
                return Typed(ir.Value(value=e.value), TRUTH)
            case s.Name():
                return self._name(e, wanted)
            case s.Member():
                return self._member(e)
            case s.Call():
                return self._call(e)
            case s.Operation():
                return self._operation(e, wanted)
            case s.Items():
                return self._items(e, wanted)
            case s.Range():
                return self._range(e)

    def fail(self, code: str, message: str, span: Span, help: str = "", notes: tuple[Note, ...] = ()) -> NoReturn:
        """Report a mistake and give up on the value."""
        self.report.add(code, message, span, help, notes)
        raise Failed

    def misfit(self, span: Span, found: Kind, wanted: tuple[Kind, ...], what: str) -> NoReturn:
        """Report a value of the wrong kind."""
        names = " or ".join(article(str(k)) for k in wanted)
        examples = [f"`{_example(k)}`" for k in wanted if _example(k)]
        code = (
            "WMS301" if isinstance(found, Quantity | Vector) and isinstance(wanted[0], Quantity | Vector) else "WMS302"
        )
        help = f"write something like {' or '.join(examples)}" if examples else ""
        self.fail(code, f"{what} wants {names}, but this is {article(str(found))}", span, help)

    # ------------------------------------------------------------ atoms

    def _number(self, value: float, unit: str | None, span: Span) -> Typed:
        scale, dimension = self.unit(unit, span) if unit else (1.0, NUMBER)
        if not math.isfinite(value * scale):
            self.fail("WMS304", "this number is too large", span)
        if value == 0 and unit is None:
            dimension = ZERO
        return Typed(ir.Value(value=units.convert(value, scale)), Quantity(dimension))

    def unit(self, unit: str, span: Span) -> tuple[float, Dimension]:
        """The SI value and dimension of a unit as written."""
        try:
            return units.parse_unit(unit)
        except units.UnknownUnit as error:
            self.fail("WMS103", f"unknown unit `{error}`", span, suggestion(str(error), units.UNITS))

    def _name(self, e: s.Name, wanted: tuple[Kind, ...]) -> Typed:
        declared = self.scope.names.get(e.id)
        match declared:
            case s.Factor():
                return Typed(
                    ir.Ref(name=e.id), self.once(("factor", e.id), e.span, lambda: self._factor(declared)).kind
                )
            case s.Let():
                return Typed(
                    ir.Ref(name=e.id), self.once(("let", e.id), e.span, lambda: self.infer(declared.value)).kind
                )
            case s.Block():
                kinds: dict[str, Kind] = {"object": OBJECT, "camera": CAMERA}
                if declared.kind not in kinds:
                    self.fail("WMS302", f"the {declared.kind} is not a value", e.span)
                return Typed(ir.Value(value=e.id), kinds[declared.kind])
            case s.Action():
                return Typed(ir.Value(value=e.id), ACTION)
        if e.id == "end":
            return Typed(ir.Ref(name="end"), A_TIME)
        for vocabulary in WORDS:
            if e.id in WORDS[vocabulary]:
                return Typed(ir.Value(value=e.id), Word(vocabulary))
        self.fail("WMS201", f"`{e.id}` is not known here", e.span, self._suggest(e.id, wanted))

    def _suggest(self, name: str, wanted: tuple[Kind, ...]) -> str:
        words = [w for k in wanted if isinstance(k, Word) for w in WORDS.get(k.vocabulary, ())]
        if OBJECT in wanted:
            words += self.scope.blocks("object")
        if CAMERA in wanted:
            words += self.scope.blocks("camera")
        return (words and suggestion(name, [*words, *self.scope.of(s.Factor, s.Let)])) or suggestion(
            name, self.scope.known()
        )

    def _factor(self, factor: s.Factor) -> Typed:
        return Typed(ir.Ref(name=factor.name.id), self.domain_of(factor))

    def factor_kind(self, factor: s.Factor) -> Kind:
        """The kind of a factor's values: that of the items of its domain."""
        typed = self.infer(factor.domain)
        if isinstance(typed.kind, List) and typed.kind.item is not None:
            return typed.kind.item
        self.fail("WMS401", f"`{factor.name.id}` needs a list or a range of values", factor.domain.span,
                  "write `[a, b, c]`, `a .. b by c` or `a .. b in 5`")  # fmt: skip

    def once(self, key: tuple[str, str], span: Span, make: Callable[[], Typed]) -> Typed:
        """Check a declaration the first time it is needed; a circle of declarations is a mistake."""
        if any(key == k for k, _ in self._open):
            notes = tuple(Note(f"`{'.'.join(k)}` needs this", where) for k, where in self._open[1:])
            self._known[key] = None
            self.fail("WMS209", "this value depends on itself", span, "break the circle with a constant", notes)
        if key not in self._known:
            self._open.append((key, span))
            try:
                self._known[key] = make()
            except Failed:
                self._known[key] = None
            finally:
                self._open.pop()
        known = self._known[key]
        if known is None:
            raise Failed
        return known

    # ------------------------------------------------------------ members and calls

    def _member(self, e: s.Member) -> Typed:
        owner = self.infer(e.value)
        if owner.kind == ACTION and isinstance(owner.expr, ir.Value):
            return Typed(
                ir.Property(owner=owner.expr, name=e.name.id), self.argument_kind(str(owner.expr.value), e.name)
            )
        if owner.kind not in (OBJECT, CAMERA):
            self.fail("WMS203", f"{article(str(owner.kind))} has no properties", e.name.span)
        table = PROPERTIES["object" if owner.kind == OBJECT else "camera"]
        slot = self.slot(table, e.name, f"{article(str(owner.kind))}")
        return Typed(ir.Property(owner=owner.expr, name=e.name.id), self._property_kind(owner.expr, e.name, slot))

    def slot(self, table: dict[str, Slot], name: s.Name, owner: str) -> Slot:
        """The row of a property table, or a complaint."""
        if name.id not in table:
            self.fail("WMS203", f"{owner} has no property `{name.id}`", name.span, suggestion(name.id, table))
        return table[name.id]

    def _property_kind(self, owner: ir.Expr, name: s.Name, slot: Slot) -> Kind:
        if not isinstance(owner, ir.Value):
            return slot.kinds[0]
        block = self.scope.names[str(owner.value)]
        assert isinstance(block, s.Block)
        written = next((p for p in block.properties if p.name.id == name.id), None)
        if written is not None:
            return self.setting(block, written, slot).kind
        if name.id == "at" and any(p.name.id == "on" and p.at for p in block.properties):
            return slot.kinds[0]
        if slot.default is None and name.id not in BY_MATERIAL:
            self.fail("WMS206", f"`{owner.value}` does not say its {name.id}", name.span, f"add `{name.id}:` to it",
                      (Note(f"`{owner.value}` is declared here", block.name.span),))  # fmt: skip
        return slot.kinds[0]

    def setting(self, block: s.Block, p: s.Property, slot: Slot) -> Typed:
        """The value of a written property."""
        key = (block.name.id, p.name.id)
        return self.once(key, p.name.span, lambda: self.value(p.value, slot.kinds, f"`{p.name.id}`"))

    def argument_kind(self, action: str, name: s.Name) -> Kind:
        """The kind of an action's argument, or of its `start` and `duration`."""
        declared = self.scope.names[action]
        assert isinstance(declared, s.Action)
        if name.id in ("start", "duration"):
            return A_TIME
        verb = self.verb(declared)
        return self.slot(VERBS[verb].arguments, name, f"`{verb}`").kinds[0]

    def verb(self, action: s.Action) -> str:
        """The verb of an action, or a complaint."""
        call = action.call
        name = call.function if isinstance(call, s.Call) else call
        if not isinstance(name, s.Name) or not isinstance(call, s.Call):
            self.fail("WMS204", "an action is a verb with its arguments", call.span, "write `launch(ball, ...)`")
        if name.id not in VERBS:
            self.fail("WMS204", f"there is no verb `{name.id}`", name.span, suggestion(name.id, VERBS))
        return name.id

    def _call(self, e: s.Call) -> Typed:
        if not isinstance(e.function, s.Name) or e.function.id not in FUNCTIONS:
            shown = e.function.span.text
            self.fail("WMS204", f"there is no function `{shown}`", e.function.span, suggestion(shown, FUNCTIONS))
        name = e.function.id
        function = FUNCTIONS[name]
        if function.measured and not self.measured:
            self.fail("WMS303", f"`{name}` is measured on the executed episode; here it is still being described",
                      e.span, "use it in `answer`, `ensure` or `margin`")  # fmt: skip
        if len(e.arguments) != len(function.parameters):
            wants = ", ".join(str(p) for p in function.parameters)
            self.fail(
                "WMS205",
                f"`{name}` takes {len(function.parameters)} argument(s), not {len(e.arguments)}",
                e.span,
                f"write `{name}({wants})`",
            )
        arguments = tuple(
            self.value(a.value, (p,), f"`{name}`").expr for a, p in zip(e.arguments, function.parameters, strict=True)
        )
        if name == "toward":
            if self.subject is None:
                self.fail("WMS205", "`toward` needs an acting object: it is for the arguments of actions", e.span)
            arguments = (self.subject, *arguments)
        return Typed(ir.Call(function=name, arguments=arguments), function.result)

    # ------------------------------------------------------------ operators

    def _operation(self, e: s.Operation, wanted: tuple[Kind, ...]) -> Typed:
        if e.operator == "if":
            return self._conditional(e, wanted)
        if e.operator in ("and", "or", "not"):
            operands = [self.value(o, (TRUTH,), f"`{e.operator}`") for o in e.operands]
            return _operation(e.operator, operands, TRUTH)
        if e.operator in ("==", "!=", "<", "<=", ">", ">="):
            return self._comparison(e)
        return self._arithmetic(e)

    def _conditional(self, e: s.Operation, wanted: tuple[Kind, ...]) -> Typed:
        condition = self.value(e.operands[0], (TRUTH,), "`if`")
        yes, no = (self.infer(o, wanted) for o in e.operands[1:])
        kind = _joined(yes.kind, no.kind)
        if kind is None:
            self.misfit(e.operands[2].span, no.kind, (yes.kind,), "`else`, like its `then`,")
        return _operation("if", [condition, yes, no], kind)

    def _comparison(self, e: s.Operation) -> Typed:
        left = self.infer(e.operands[0])
        right = self.infer(e.operands[1], (left.kind,))
        if _joined(left.kind, right.kind) is None:
            self.misfit(
                e.operands[1].span, right.kind, (left.kind,), f"`{e.operator}`, after {article(str(left.kind))},"
            )
        if e.operator not in ("==", "!=") and not isinstance(left.kind, Quantity):
            self.fail("WMS302", f"`{e.operator}` compares quantities, not {left.kind}s", e.span, "use `==` or `!=`")
        return _operation(e.operator, [left, right], TRUTH)

    def _arithmetic(self, e: s.Operation) -> Typed:
        operands = [self.infer(o) for o in e.operands]
        kinds = []
        for operand, written in zip(operands, e.operands, strict=True):
            if not isinstance(operand.kind, Quantity):
                self.fail(
                    "WMS302",
                    f"`{e.operator}` wants quantities, but this is {article(str(operand.kind))}",
                    written.span,
                )
            kinds.append(operand.kind)
        dimensions = [NUMBER if k.dimension == ZERO and e.operator in "*/" else k.dimension for k in kinds]
        if len(operands) == 1:
            return _operation("-", operands, kinds[0])
        if e.operator == "*":
            return _operation("*", operands, Quantity(dimensions[0] * dimensions[1]))
        if e.operator == "/":
            return _operation("/", operands, Quantity(dimensions[0] / dimensions[1]))
        kind = _joined(*kinds)
        if kind is None:
            self.misfit(e.operands[1].span, kinds[1], (kinds[0],), f"`{e.operator}`, after {article(str(kinds[0]))},")
        return _operation(e.operator, operands, kind)

    # ------------------------------------------------------------ lists, tuples, ranges

    def _items(self, e: s.Items, wanted: tuple[Kind, ...]) -> Typed:
        inner = tuple(k.item for k in wanted if isinstance(k, List) and k.item) or wanted
        items = [self.infer(i, inner) for i in e.items]
        if e.unit is not None:
            items = [self._scaled(i, e.unit, span) for i, span in zip(items, (x.span for x in e.items), strict=True)]
        kind = items[0].kind if items else None
        for item, written in zip(items, e.items, strict=True):
            joined = _joined(kind, item.kind) if kind else None
            if kind is not None and joined is None:
                self.misfit(written.span, item.kind, (kind,), f"this {e.kind}, like its first item,")
            kind = joined
        expr = ir.Items(items=tuple(i.expr for i in items))
        if e.kind == "list":
            return Typed(expr, List(kind))
        if not isinstance(kind, Quantity) or len(items) > 3:
            self.fail("WMS302", "a tuple holds two or three quantities", e.span, "use `[...]` for a list")
        return Typed(expr, Vector(kind.dimension, len(items)))

    def _scaled(self, item: Typed, unit: str, span: Span) -> Typed:
        scale, dimension = self.unit(unit, span)
        if not fits(item.kind, A_NUMBER):
            self.fail("WMS301", "this value has a unit of its own already, beside that of the list", span)
        value = item.expr.value if isinstance(item.expr, ir.Value) else None
        if isinstance(value, float):
            return Typed(ir.Value(value=units.convert(value, scale)), Quantity(dimension))
        expr = ir.Operation(operator="*", operands=(item.expr, ir.Value(value=scale)))
        return Typed(expr, Quantity(dimension))

    def _range(self, e: s.Range) -> Typed:
        start, stop = self.infer(e.start), self.infer(e.stop)
        kind = _joined(start.kind, stop.kind)
        if not isinstance(kind, Quantity):
            self.misfit(e.stop.span, stop.kind, (start.kind,), "`..`, like its start,")
        if e.step is not None:
            step = self.value(e.step, (kind,), "`by`")
            return Typed(self._steps(e, start.expr, stop.expr, step.expr), List(kind))
        count = self._count(e) if e.count is not None else 2
        return Typed(_points(start.expr, stop.expr, count), List(kind))

    def _count(self, e: s.Range) -> int:
        assert e.count is not None
        count = constant(self.value(e.count, (A_NUMBER,), "`in`").expr)
        if count is None or count != int(count) or not 2 <= count <= 10_000:
            self.fail("WMS304", "the number of values is a whole constant from 2 to 10000", e.count.span)
        return int(count)

    def _steps(self, e: s.Range, start: ir.Expr, stop: ir.Expr, step: ir.Expr) -> ir.Items:
        a, b, by = constant(start), constant(stop), constant(step)
        if a is None or b is None or by is None:
            self.fail("WMS304", "a range with steps has constant ends", e.span, "use `a .. b in 5`")
        if by <= 0 or b < a:
            self.fail("WMS401", "this range is empty: it goes up from its start to its end", e.span)
        steps = (b - a) / by + 1e-9
        if not steps < 10_000:
            count = f"{int(steps) + 1}" if math.isfinite(steps) else "endlessly many"
            self.fail("WMS401", f"this range has {count} values; 10000 are the most", e.span, "take a larger step")
        return ir.Items(items=tuple(ir.Value(value=round(a + i * by, 12)) for i in range(int(steps) + 1)))


# ---------------------------------------------------------------- kinds


def fits(kind: Kind, wanted: Kind) -> bool:
    """Whether a value of this kind may stand where the other is wanted."""
    return _joined(kind, wanted) == wanted


def _joined(a: Kind, b: Kind) -> Kind | None:
    """The common kind of two values, None if they have none. A bare zero and an empty list give way."""
    match a, b:
        case Quantity(dimension), Quantity() if dimension == ZERO:
            return b
        case Quantity(), Quantity(dimension) if dimension == ZERO:
            return a
        case Vector(dimension, n), Vector(_, m) if dimension == ZERO and n == m:
            return b
        case Vector(_, n), Vector(dimension, m) if dimension == ZERO and n == m:
            return a
        case List(None), List():
            return b
        case List(x), List(y) if x and y:
            item = _joined(x, y)
            return List(item) if item else None
    return a if a == b else None


def _operation(operator: str, operands: list[Typed], kind: Kind) -> Typed:
    values = [o.expr.value for o in operands if isinstance(o.expr, ir.Value) and isinstance(o.expr.value, float)]
    expr = ir.Operation(operator=operator, operands=tuple(o.expr for o in operands))
    if len(values) == len(operands) and (folded := constant(expr)) is not None:
        return Typed(ir.Value(value=folded), kind)
    return Typed(expr, kind)


def constant(expr: ir.Expr) -> float | None:
    """The value of an expression of constant numbers; None if it is anything else."""
    match expr:
        case ir.Value(value=float(value)):
            return value
        case ir.Operation(operator="-", operands=(a,)):
            return None if (x := constant(a)) is None else -x
        case ir.Operation(operator=("+" | "-" | "*" | "/") as operator, operands=(a, b)):
            x, y = constant(a), constant(b)
            if x is None or y is None or (operator == "/" and y == 0):
                return None
            result = {"+": x + y, "-": x - y, "*": x * y, "/": x / (y or 1)}[operator]
            return result if math.isfinite(result) else None
    return None


def _points(start: ir.Expr, stop: ir.Expr, count: int) -> ir.Items:
    a, b = constant(start), constant(stop)
    if a is not None and b is not None:
        return ir.Items(items=tuple(ir.Value(value=round(a + (b - a) * i / (count - 1), 12)) for i in range(count)))
    span = ir.Operation(operator="-", operands=(stop, start))
    shares = (ir.Value(value=i / (count - 1)) for i in range(count))
    steps = (ir.Operation(operator="*", operands=(span, share)) for share in shares)
    return ir.Items(items=tuple(ir.Operation(operator="+", operands=(start, step)) for step in steps))


def _example(kind: Kind) -> str:
    match kind:
        case Quantity(dimension):
            return units.EXAMPLES.get(dimension, "")
        case Vector(dimension, size) if dimension in units.EXAMPLES:
            return f"({', '.join([units.EXAMPLES[dimension]] * size)})"
        case Word(vocabulary):
            return WORDS[vocabulary][-1]
    return ""
