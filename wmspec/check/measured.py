"""Is a value read off what happens, or known before anything does?"""

from __future__ import annotations

from wmspec.check.evaluate import parts
from wmspec.check.functions import FUNCTIONS
from wmspec.check.ir import Call, Expr, Ref, TaskSpec


def measured(spec: TaskSpec, expr: Expr) -> bool:
    """Whether anything in it is measured on the executed episode."""
    lets = {let.name: let.value for let in spec.lets}
    waiting, seen = [expr], set[str]()
    while waiting:
        for part in parts(waiting.pop()):
            if isinstance(part, Call) and part.function in FUNCTIONS and FUNCTIONS[part.function].measured:
                return True
            if isinstance(part, Ref) and part.name in lets and part.name not in seen:
                seen.add(part.name)
                waiting.append(lets[part.name])
    return False
