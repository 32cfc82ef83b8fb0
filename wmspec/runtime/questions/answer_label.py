"""The label by which answers are counted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir.ir import Question
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import Reject
from wmspec.runtime.questions.question_context import QuestionContext


def member_label(question: Question, levels: Mapping[str, Any], names: Mapping[str, str | None]) -> str:
    """Return the levels of an instance's member of a closed set, such as `fill empty, pace slow`; '' without a set.

    `levels` are those of all factors, `names` the words of named ones.
    """
    own = [(varied.factor, names.get(varied.factor) or levels[varied.factor]) for varied in question.orbit]
    return ", ".join(
        f"{factor} {level:g}" if isinstance(level, float) else f"{factor} {level}" for factor, level in own
    )


def answer_label(asking: QuestionContext) -> str:
    """Return the answer of an executed instance before gates, in words; '' if it is open, a picture or undefined."""
    kind = KINDS[asking.question.kind]
    if not kind.countable:
        return ""
    try:
        return kind.words(asking, kind.answer(asking))
    except (Reject, WmsError):
        return ""
