"""Rules on designs: idle conditions and samples larger than the design."""

from __future__ import annotations

from collections.abc import Iterator

from wmspec.compile.design.design import Design
from wmspec.compile.lint.rule import Breach, rule


@rule("WMS406")
def idle_require(design: Design) -> Iterator[Breach]:
    """Find conditions that exclude nothing."""
    for number, require in enumerate(design.spec.requires):
        if all(len(c.allowed) == c.tries for c in design.conditions if c.statement == number):
            yield Breach("this `require` excludes nothing", require.place, "remove it, or fix its condition")


@rule("WMS408")
def short_sample(design: Design) -> Iterator[Breach]:
    """Find samples larger than the number of combinations."""
    plan, size = design.spec.plan, len(design.blocks.members(0))
    if plan.kind == "sample" and plan.count and plan.place and size < plan.count:
        message = f"a sample of {plan.count} exceeds the {size} combinations"
        yield Breach(message, plan.place, "ask for fewer, widen a domain, or say `repeat`")


RULES = (idle_require, short_sample)
