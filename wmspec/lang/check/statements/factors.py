"""Checks factors, nuisances, `let`s, `require`s, and the design."""

from __future__ import annotations

from typing import cast

from wmspec.core.diagnostics import Note, suggestion
from wmspec.core.places import Location, Span
from wmspec.lang.check.expressions.domains import Level, WrittenDomain, conditions, labels, read_domain
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import ZERO, Failed, constant
from wmspec.lang.check.ir import ir
from wmspec.lang.check.ir.evaluate import subexpressions
from wmspec.lang.check.tables.vocabulary import DESIGNS, DIMENSION_ALIASES, FACTOR_DIMENSIONS
from wmspec.lang.check.types.types import A_NUMBER, TRUTH, Quantity, Type, Vector
from wmspec.lang.parse import syntax as s

#: Maximum number of instances.
MAX_INSTANCES = 10_000_000
#: Keys of a design in groups: crossed factors, rotating factors, and the question with balanced answers.
GROUP_KEYS = ("cross", "turn", "balance")


class Factors:
    """Checks the statements of the design; an error is reported and raises `Failed`."""

    def __init__(self, check: Expressions) -> None:
        self.check = check
        check.domain_of = self.type_of

    def type_of(self, factor: s.Factor) -> Type:
        """Return the type of a factor's values."""
        return read_domain(self.check, factor.domain).type

    # ------------------------------------------------------------ factors

    def factor(self, factor: s.Factor) -> ir.Factor:
        """Return a factor or nuisance with its domain."""
        written = read_domain(self.check, factor.domain)
        domain = self._drawn(factor, written) if factor.nuisance else self._studied(factor, written)
        kind = written.type
        dimension = kind.dimension if isinstance(kind, Quantity | Vector) and kind.dimension != ZERO else None
        return ir.Factor(
            name=factor.name.id,
            domain=domain,
            nuisance=factor.nuisance,
            unit=dimension.symbol if dimension else "",
            place=Location.of(factor.name.span),
            about=self._dimension(factor),
        )

    def _dimension(self, factor: s.Factor) -> str:
        """Return the dimension that a factor is declared `about`, or ''."""
        word = factor.about
        if word is None or word.id in FACTOR_DIMENSIONS:
            return word.id if word else ""
        known = DIMENSION_ALIASES.get(word.id, "")
        remedy = f"write `about {known}`" if known else suggestion(word.id, FACTOR_DIMENSIONS)
        self.check.fail("WMS201", f"there is no dimension `{word.id}`", word.span, remedy)

    def _drawn(self, factor: s.Factor, written: WrittenDomain) -> ir.Domain:
        """Return the domain of a nuisance. It cannot depend on factors, or neighbours would differ in two variables."""
        name = factor.name.id
        if written.conditional:
            message = f"what the nuisance `{name}` is drawn from depends on a condition"
            remedy = "draw from each domain by itself, and choose between the nuisances with `let`"
            self.check.fail("WMS407", message, factor.domain.span, remedy)
        values = tuple(o.value for o in written.options)
        return written.spread or ir.Choices(values=values, weights=written.weights, names=labels(written))

    def _studied(self, factor: s.Factor, written: WrittenDomain) -> ir.Domain:
        """Return the values of a factor; only a Latin hypercube accepts intervals and distributions."""
        name, span = factor.name.id, factor.domain.span
        if written.weights is not None:
            message = f"`{name}` is a factor, and all values of a factor count alike"
            self.check.fail("WMS401", message, span, "only a nuisance is `weighted`; of a factor, write the list")
        if written.spread is not None:
            if not any(d.kind.id == "latin" for d in self.check.scope.designs):
                message = f"`{name}` is a factor and so needs separate values"
                remedy = "add `by STEP` or `in COUNT`; only a nuisance is drawn from a whole interval"
                self.check.fail("WMS401", message, span, remedy)
            return written.spread
        if not written.conditional:
            return ir.Choices(values=tuple(o.value for o in written.options), names=labels(written))
        values, when = zip(*conditions(self.check, written), strict=True)
        if any(part == ir.Ref(name=name) for condition in when for part in subexpressions(condition)):
            self.check.fail("WMS209", f"the values of `{name}` depend on itself", span, "let them depend on others")
        return ir.Choices(values=values, when=when, names=labels(written))

    # ------------------------------------------------------------ lets and requires

    def let(self, let: s.Let) -> ir.Let:
        """Return a named value."""
        typed = self.check.memoized(("let", let.name.id), let.name.span, lambda: self.check.infer(let.value))
        return ir.Let(name=let.name.id, value=typed.expr, place=Location.of(let.name.span))

    def require(self, require: s.Require) -> ir.Require:
        """Return a condition on factors."""
        typed = self.check.value(require.condition, (TRUTH,), "`require`")
        return ir.Require(
            condition=typed.expr, text=require.condition.span.words, place=Location.of(require.condition.span)
        )

    # ------------------------------------------------------------ the design

    def plan(self) -> ir.Plan:
        """Return the design, by default factorial. Errors are reported."""
        if not self.check.scope.designs:
            return ir.Plan()
        self.check.report.add_set_twice(("design", design.span) for design in self.check.scope.designs)
        try:
            return self._plan(self.check.scope.designs[0])
        except Failed:
            return ir.Plan()

    def _plan(self, design: s.Design) -> ir.Plan:
        kind, name = design.kind.id, design.kind
        if kind not in DESIGNS:
            self.check.fail("WMS201", f"there is no design `{kind}`", name.span, suggestion(kind, DESIGNS))
        if DESIGNS[kind].counted and design.count is None:
            self.check.fail(
                "WMS408", f"`{kind}` needs a number of instances", name.span, f"write `design {kind} of 500`"
            )
        if design.count is not None and not DESIGNS[kind].counted:
            remedy = "write `design sample of N` for N of them"
            self.check.fail(
                "WMS408", f"the number of instances of `{kind}` follows from the factors", design.count.span, remedy
            )
        if design.baseline and kind not in ("one_at_a_time", "groups"):
            remedy = "only `design one_at_a_time { ... }` varies factors around one"
            self.check.fail("WMS408", f"`{kind}` has no baseline", design.baseline[0].span, remedy)
        count = None if design.count is None else self._count(design.count)
        plan, place = cast(ir.PlanKind, kind), Location.of(design.span)
        if kind == "groups":
            named = self._grouped(design)
            cross, turn, balance = (named.get(key, ()) for key in GROUP_KEYS)
            return ir.Plan(kind=plan, count=count, cross=cross, turn=turn, balance="".join(balance), place=place)
        return ir.Plan(kind=plan, count=count, baseline=self._baseline(design), place=place)

    def _grouped(self, design: s.Design) -> dict[str, tuple[str, ...]]:
        """Return the factors named by `cross` and `turn`, and the question named by `balance`."""
        named: dict[str, tuple[str, ...]] = {}
        taken: dict[str, Span] = {}
        for p in design.baseline:
            if p.name.id not in GROUP_KEYS:
                remedy = suggestion(p.name.id, GROUP_KEYS)
                self.check.fail("WMS203", f"groups have no `{p.name.id}`", p.name.span, remedy)
            if p.name.id in named:
                self.check.fail("WMS202", f"`{p.name.id}` is set twice", p.name.span, "put the names in one list")
            names = p.value.items if isinstance(p.value, s.Items) else (p.value,)
            balance = p.name.id == "balance"
            named[p.name.id] = (self._question(p.value),) if balance else tuple(self._factor(e, taken) for e in names)
        if not {"cross", "turn"} & named.keys():
            remedy = "write `{ cross: FACTOR }`, or `{ turn: [FACTOR, ...] }` for factors that take turns"
            self.check.fail("WMS408", "groups need crossed factors", design.kind.span, remedy)
        return named

    def _question(self, e: s.Expr) -> str:
        """Return the name of a question."""
        named = [q.name.id for q in self.check.scope.questions if q.name is not None]
        if isinstance(e, s.Name) and e.id in named:
            return e.id
        name = e.span.text
        remedy = suggestion(name, named) or 'name one: `question NAME "..." { ... }`, and balance its answers'
        self.check.unknown(s.Name(name, e.span), f"there is no question `{name}`", remedy)

    def _factor(self, e: s.Expr, taken: dict[str, Span]) -> str:
        """Return the name of a factor, which must not be `taken`."""
        name = e.span.text
        self.declared(name, e.span)
        if name in taken:
            notes = (Note("named here first", taken[name]),)
            self.check.fail("WMS202", f"`{name}` is named twice", e.span, "name it once", notes)
        taken[name] = e.span
        return name

    def declared(self, name: str, span: Span) -> s.Factor:
        """Return the factor of that name."""
        factor = self.check.scope.names.get(name)
        if not isinstance(factor, s.Factor) or factor.nuisance:
            factors = [f for f, x in self.check.scope.names.items() if isinstance(x, s.Factor) and not x.nuisance]
            self.check.unknown(s.Name(name, span), f"there is no factor `{name}`", suggestion(name, factors))
        return factor

    def _count(self, e: s.Expr) -> int:
        count = constant(self.check.value(e, (A_NUMBER,), "`of`").expr)
        if count is None or count != int(count) or not 1 <= count <= MAX_INSTANCES:
            self.check.fail(
                "WMS408", f"the number of instances is a whole constant from 1 to {MAX_INSTANCES:,}", e.span
            )
        return int(count)

    def _baseline(self, design: s.Design) -> dict[str, Level]:
        levels: dict[str, Level] = {}
        for p in design.baseline:
            name = p.name.id
            factor = self.declared(name, p.name.span)
            if name in levels:
                self.check.fail("WMS202", f"`{name}` is set twice", p.name.span, "remove one")
            if p.at is not None:
                self.check.fail("WMS101", "`at` has no meaning here", p.at.span, "write one value")
            levels[name] = self.level(factor, p.value)
        return levels

    def level(self, factor: s.Factor, e: s.Expr) -> Level:
        """Return one of the values of a factor."""
        written = read_domain(self.check, factor.domain)
        names = labels(written) or ()
        if isinstance(e, s.Text) and e.value in names:
            return written.options[names.index(e.value)].value
        expr = self.check.value(e, (written.type,), f"`{factor.name.id}`").expr
        for option in written.options:
            if _same(option.value, expr):
                return option.value
        message = f"`{e.span.text}` is none of the values of `{factor.name.id}`"
        notes = (Note("they are these", factor.domain.span),)
        self.check.fail("WMS304", message, e.span, "add it to them, or write one of them", notes)


def _same(value: Level, expr: ir.Expr) -> bool:
    """Whether a constant equals a value, up to rounding of units."""
    if isinstance(value, tuple):
        items = expr.items if isinstance(expr, ir.Items) else ()
        return len(items) == len(value) and all(map(_same, value, items))
    number = constant(expr)
    if isinstance(value, float) and number is not None:
        return abs(value - number) <= 1e-9 * max(1.0, abs(value))
    return expr == ir.Value(value=value)
