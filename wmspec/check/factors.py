"""Checking what varies: factors, nuisances, `let`s and `require`s."""

from __future__ import annotations

from wmspec.check import ir
from wmspec.check.expressions import ZERO, Expressions, constant
from wmspec.check.kinds import TRUTH, Quantity
from wmspec.parse import syntax as s


class Factors:
    """Checks the statements of the design; a mistake is reported and raises `Failed`."""

    def __init__(self, check: Expressions) -> None:
        self.check = check

    def factor(self, factor: s.Factor) -> ir.Factor:
        """A factor or nuisance with its domain."""
        name = factor.name.id
        typed = self.check.infer(factor.domain)
        kind = self.check.factor_kind(factor)
        interval = isinstance(factor.domain, s.Range) and factor.domain.step is None and factor.domain.count is None
        if interval and not factor.nuisance:
            self.check.fail("WMS401", f"`{name}` is a factor and so needs separate values", factor.domain.span,
                            "add `by STEP` or `in COUNT`; only a nuisance is drawn from a whole interval")  # fmt: skip
        values = self.values(typed.expr, factor)
        domain = (
            ir.Interval(low=float(values[0]), high=float(values[1])) if interval else ir.Choices(values=tuple(values))
        )
        if isinstance(domain, ir.Interval) and domain.high < domain.low:
            self.check.fail(
                "WMS401", "this interval is empty: it goes up from its start to its end", factor.domain.span
            )
        unit = kind.dimension.symbol if isinstance(kind, Quantity) and kind.dimension != ZERO else ""
        return ir.Factor(
            name=name, domain=domain, nuisance=factor.nuisance, unit=unit, place=ir.Place.of(factor.name.span)
        )

    def values(self, domain: ir.Expr, factor: s.Factor) -> list[bool | float | str]:
        """The constants of a domain. Two equal ones are a mistake."""
        assert isinstance(domain, ir.Items)
        written = factor.domain.items if isinstance(factor.domain, s.Items) else ()
        spans = [w.span for w in written] or [factor.domain.span] * len(domain.items)
        values: list[bool | float | str] = []
        for item, span in zip(domain.items, spans, strict=True):
            value = item.value if isinstance(item, ir.Value) else constant(item)
            if value is None:
                self.check.fail("WMS401", "the values of a domain are constants", span, "write them out")
            if value in values and len(written) > 0:
                self.check.fail("WMS401", "this value is in the domain twice", span, "remove one")
            values.append(value)
        if not values:
            self.check.fail("WMS401", f"`{factor.name.id}` has no values", factor.domain.span)
        return values

    def let(self, let: s.Let) -> ir.Let:
        """A named value."""
        typed = self.check.once(("let", let.name.id), let.name.span, lambda: self.check.infer(let.value))
        return ir.Let(name=let.name.id, value=typed.expr, place=ir.Place.of(let.name.span))

    def require(self, require: s.Require) -> ir.Require:
        """A condition on factors."""
        typed = self.check.value(require.condition, (TRUTH,), "`require`")
        return ir.Require(
            condition=typed.expr, text=require.condition.span.text, place=ir.Place.of(require.condition.span)
        )
