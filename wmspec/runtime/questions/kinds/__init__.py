"""The kinds of questions, one module each. A new kind is a module, and a row here and in the checker."""

from __future__ import annotations

from typing import Any

from wmspec.lang.check.ir.ir import QuestionKind
from wmspec.runtime.questions.kinds.kind import Kind
from wmspec.runtime.questions.kinds.labels import Labels
from wmspec.runtime.questions.kinds.numbers import Numbers
from wmspec.runtime.questions.kinds.pictures import Pictures
from wmspec.runtime.questions.kinds.possible import Possible

#: Kinds by their name in the IR.
KINDS: dict[QuestionKind, Kind[Any]] = {
    "labels": Labels(),
    "numbers": Numbers(),
    "pictures": Pictures(),
    "possible": Possible(),
}

__all__ = ["KINDS", "Kind"]
