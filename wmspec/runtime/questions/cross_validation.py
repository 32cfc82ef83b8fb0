"""Questions of an instance that several engines answer, as one row a question or as one row an engine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from wmspec.compile.design.design import Design, Instance
from wmspec.runtime.questions.ask import measurement, question_row, rejected
from wmspec.runtime.questions.consensus import Answered, Consensus, Distances, consensus, judge
from wmspec.runtime.questions.model import QuestionRow, Reject, Rejected
from wmspec.runtime.questions.runs import EnginePair, Run, execute

T = TypeVar("T")


class CrossValidation:
    """An instance of a design in several engines. The first engine is the reference.

    Each engine executes the instance when its answer is first needed.
    """

    def __init__(self, design: Design, index: int, pairs: Mapping[str, EnginePair], required: Consensus) -> None:
        self._design, self._instance, self._pairs, self._required = design, design[index], pairs, required
        self._runs: dict[str, Run | Reject] = {}
        self._distances: dict[str, Distances] = {}

    def questions(self) -> list[QuestionRow | Rejected]:
        """Return one row a question, or its rejection.

        The row is that of the reference engine. The other engines confirm the answer. Without unanimity as the
        requirement, the row is that of the first engine whose answer is kept.
        """
        return [self._question(q) for q in range(len(self._design.spec.questions))]

    def rows(self) -> list[QuestionRow | Rejected]:
        """Return one row for each question and engine, or its rejection."""
        answers: list[QuestionRow | Rejected] = []
        for q in range(len(self._design.spec.questions)):
            rows = {engine: self._made(q, engine, question_row) for engine in self._pairs}
            kept = [engine for engine, row in rows.items() if isinstance(row, QuestionRow)]
            answers += consensus(rows, self._required, {engine: self._apart(engine) for engine in kept}).values()
        return answers

    def _question(self, q: int) -> QuestionRow | Rejected:
        engines = list(self._pairs)
        first: Rejected | None = None
        measured: dict[str, Answered] = {}
        for engine in engines[:1] if self._required == "all" else engines:
            row = self._made(q, engine, question_row)
            if isinstance(row, QuestionRow):
                missing = [other for other in engines if other != engine and other not in measured]
                measured |= {other: self._made(q, other, measurement) for other in missing}
                row = judge(row, measured | {engine: row}, self._required, self._apart(engine))
            if isinstance(row, QuestionRow):
                return row
            first = first or row
        assert first is not None
        return first

    def _made(
        self, q: int, engine: str, make: Callable[[Design, Instance, int, Run, EnginePair], T | Rejected]
    ) -> T | Rejected:
        """Return what `make` makes of a question in an engine; a rejection if the engine did not execute it."""
        run, pair = self._run(engine), self._pairs[engine]
        if isinstance(run, Reject):
            return rejected(self._design, self._instance, q, pair, run)
        return make(self._design, self._instance, q, run, pair)

    def _run(self, engine: str) -> Run | Reject:
        if engine not in self._runs:
            try:
                self._runs[engine] = execute(self._design, self._instance, None, self._pairs[engine])
            except Reject as reject:
                self._runs[engine] = reject
        return self._runs[engine]

    def _apart(self, engine: str) -> Distances:
        """Return the largest distance (m) of a body between this engine and every engine that executed the instance."""
        mine = self._runs[engine]
        if isinstance(mine, Reject) or engine in self._distances:
            return self._distances.get(engine, {})
        runs = {other: run for other, run in self._runs.items() if isinstance(run, Run)}
        self._distances[engine] = {other: mine.distance(run) for other, run in runs.items()}
        return self._distances[engine]
