"""Is a value read off what happens, or known before anything does?"""

from __future__ import annotations

from wmspec.lang.check.ir.evaluate import parts
from wmspec.lang.check.ir.ir import Call, Expr, Ref, TaskSpec
from wmspec.lang.check.tables.functions import FUNCTIONS


def measured(spec: TaskSpec, expr: Expr) -> bool:
    """Whether anything in it is measured on the executed episode."""
    return bool(_measures(spec, expr))


def moments(spec: TaskSpec, expr: Expr) -> int:
    """How many moments of the episode it takes to see a value: 1 if any shows it, 2 for a change, 3 for a course."""
    return max((FUNCTIONS[name].moments for name in _measures(spec, expr)), default=1)


def _measures(spec: TaskSpec, expr: Expr) -> set[str]:
    """The functions in it that measure the executed episode."""
    lets = {let.name: let.value for let in spec.lets}
    waiting, seen, measures = [expr], set[str](), set[str]()
    while waiting:
        for part in parts(waiting.pop()):
            if isinstance(part, Call) and part.function in FUNCTIONS and FUNCTIONS[part.function].measured:
                measures.add(part.function)
            if isinstance(part, Ref) and part.name in lets and part.name not in seen:
                seen.add(part.name)
                waiting.append(lets[part.name])
    return measures
