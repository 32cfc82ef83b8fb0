"""Checks `answer possible`: whether an episode is possible depends on actions that break the laws of physics."""

from __future__ import annotations

from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import Typed
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.verbs import VERBS
from wmspec.lang.check.types.types import POSSIBILITY, either
from wmspec.lang.parse import syntax as s

#: The answers.
POSSIBLE, IMPOSSIBLE = "possible", "impossible"
#: Verbs that break the laws of physics.
VIOLATIONS = tuple(sorted(name for name, verb in VERBS.items() if verb.violates))
#: The options, and the expression that stands for the answer: the engines decide it.
POSSIBLE_OPTIONS = ir.Items(items=(ir.Value(value=POSSIBLE), ir.Value(value=IMPOSSIBLE)))
POSSIBLE_ANSWER = Typed(ir.Value(value=POSSIBLE), POSSIBILITY)


def is_possibility(check: Expressions, value: s.Expr) -> bool:
    """Whether the value of `answer` is the word `possible`, and no name that the task declares."""
    return isinstance(value, s.Name) and value.id == POSSIBLE and POSSIBLE not in check.scope.names


def require_violation(check: Expressions, value: s.Expr) -> None:
    """Report a task in which no action can break the laws of physics."""
    actions = (name for name in check.scope.names.values() if isinstance(name, s.Action))
    if not any(_verb(action) in VIOLATIONS for action in actions):
        verbs = either([f"`{name}`" for name in VIOLATIONS])
        remedy = (
            f"add an action with {verbs} that changes nothing in some instances, such as `paint` in the same colour"
        )
        check.fail("WMS502", "every episode of this task is possible", value.span, remedy)


def _verb(action: s.Action) -> str:
    function = action.call.function if isinstance(action.call, s.Call) else None
    return function.id if isinstance(function, s.Name) else ""
