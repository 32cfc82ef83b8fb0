"""The kinds of questions, each alone in its module. A new one is a module and a row here and in the checker."""

from __future__ import annotations

from typing import Any

from wmspec.lang.check.ir.ir import QuestionKind
from wmspec.runtime.questions.kinds.kind import Kind
from wmspec.runtime.questions.kinds.labels import Labels
from wmspec.runtime.questions.kinds.numbers import Numbers
from wmspec.runtime.questions.kinds.pictures import Pictures

#: Every kind by its name in the IR.
KINDS: dict[QuestionKind, Kind[Any]] = {"labels": Labels(), "numbers": Numbers(), "pictures": Pictures()}

__all__ = ["KINDS", "Kind"]
