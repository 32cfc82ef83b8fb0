"""Classifies expressions: measured on the episode, or known in advance."""

from __future__ import annotations

from wmspec.lang.check.ir.evaluate import reachable
from wmspec.lang.check.ir.ir import Call, Expr, TaskSpec
from wmspec.lang.check.tables.functions import FUNCTIONS

#: The number of moments that show a change (see `moments`), such as something impossible, and from which a course is
#: predicted: two moments show where everything is and how it moves.
CHANGE, PREDICTED = 2, 2


def is_measured(spec: TaskSpec, expr: Expr) -> bool:
    """Whether an expression contains a measurement of the executed episode."""
    return bool(_measures(spec, expr))


def moments(spec: TaskSpec, expr: Expr) -> int:
    """Return how many moments of the episode show a value: 1 for a state, 2 for a change, 3 for a course."""
    return max((FUNCTIONS[name].moments for name in _measures(spec, expr)), default=1)


def _measures(spec: TaskSpec, expr: Expr) -> set[str]:
    """Return the measuring functions in an expression."""
    lets = {let.name: let.value for let in spec.lets}
    calls = (part.function for part in reachable([expr], lets) if isinstance(part, Call))
    return {name for name in calls if name in FUNCTIONS and FUNCTIONS[name].measured}
