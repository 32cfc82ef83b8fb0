"""Random designs to test with, and what they are by brute force."""

from collections.abc import Iterator
from itertools import product
from typing import Any

from hypothesis import strategies as st

from wmspec.compile.design.levels import Level
from wmspec.lang.check.ir.ir import Choices, Operation, Plan, Ref, Require, TaskSpec, Value
from wmspec.lang.check.statements.builder import PYTHON_LOCATION, factor, nuisance, observe, task, thing

_COMPARE = {
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    ">=": lambda a, b: a >= b,
}


def compare(operator: str, a: str, b: str | float) -> Operation:
    """A factor compared with another or with a number."""
    right = Ref(name=b) if isinstance(b, str) else Value(value=float(b))
    return Operation(operator=operator, operands=(Ref(name=a), right))


def require(condition: Any, text: str = "condition") -> Require:
    """A `require` that stands in no text."""
    return Require(condition=condition, text=text, place=PYTHON_LOCATION)


def design_of(sizes: dict[str, int], *conditions: Any, plan: Plan | None = None, repeat: int = 1) -> TaskSpec:
    """A task with factors that have these numbers of values (0, 1, ...), and a nuisance."""
    factors = [factor(name, [float(i) for i in range(size)]) for name, size in sizes.items()]
    requires = [require(c, str(i)) for i, c in enumerate(conditions)]
    scene = (thing("object", "ball", shape="sphere", size=0.1), observe("front", [0.0]))
    return task("t", *factors, nuisance("n", 0, 1), *requires, *scene, plan=plan, repeat=repeat)


def allowed(spec: TaskSpec) -> Iterator[dict[str, Level]]:
    """All combinations that meet every condition, in the order of the domains, by trying them all."""
    factors = [f for f in spec.factors if not f.nuisance]
    domains = [f.domain.values for f in factors if isinstance(f.domain, Choices)]
    for row in product(*domains):
        values = {f.name: value for f, value in zip(factors, row, strict=True)}
        if all(holds(r.condition, values) for r in spec.requires):
            yield values


def holds(condition: Any, values: dict[str, Level]) -> bool:
    """Whether a condition made by `compare`, or an `and`, `or` of such, holds."""
    match condition:
        case Operation(operator="and", operands=operands):
            return all(holds(o, values) for o in operands)
        case Operation(operator="or", operands=operands):
            return any(holds(o, values) for o in operands)
        case Operation(operator=operator, operands=(a, b)):
            return bool(_COMPARE[operator](*(values[x.name] if isinstance(x, Ref) else x.value for x in (a, b))))  # type: ignore[union-attr]
    raise AssertionError(condition)


@st.composite
def random_design(draw: st.DrawFn, plan: Plan | None = None) -> TaskSpec:
    """Up to five factors with up to four conditions; none of the combinations may be allowed."""
    names = "abcde"[: draw(st.integers(1, 5))]
    sizes = {name: draw(st.integers(1, 4)) for name in names}

    def simple() -> Operation:
        other = draw(st.one_of(st.sampled_from(names), st.integers(0, 3)))
        return compare(draw(st.sampled_from(list(_COMPARE))), draw(st.sampled_from(names)), other)

    conditions = []
    for _ in range(draw(st.integers(0, 4))):
        joined = draw(st.sampled_from(["and", "or", ""]))
        conditions.append(Operation(operator=joined, operands=(simple(), simple())) if joined else simple())
    return design_of(sizes, *conditions, plan=plan, repeat=draw(st.integers(1, 2)))
