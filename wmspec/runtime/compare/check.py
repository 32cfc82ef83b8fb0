"""Executes one instance in several engines, with the counterfactuals of its questions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations

from wmspec.compile.design.design import Design, Instance
from wmspec.compile.design.what_ifs import what_ifs
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir.ir import Counterfactual, Question, TaskSpec
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.caches.scene_cache import SceneCache
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.compare.answers import EngineAnswer, agree, answer, difference
from wmspec.runtime.compare.compare import compare
from wmspec.runtime.compare.model import Cause, CheckResult, Comparison, Failure, Pair, Verdict
from wmspec.runtime.compare.tolerance import Tolerances
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import TRUTH
from wmspec.runtime.questions.question_context import QuestionContext
from wmspec.runtime.questions.runs import EnginePair, Run, values_of
from wmspec.sim.scene.model import Scene, Trace

#: Size (px) of the pictures on which `visible`, `occluded` and `contrast` are measured.
MEASUREMENT_SIZE = 256

#: A trace by engine and run.
Traces = Mapping[tuple[str, str], Trace]


def check(design: Design, index: int, engines: Sequence[TraceCache], tolerances: Tolerances) -> CheckResult:
    """Execute an instance in every engine and compare each pair of engines."""
    spec, instance = design.spec, design[index]
    scenes, failures = _scenes(design, instance)
    traces, failed = _execute(scenes, engines)
    pairs = list(combinations([e.engine for e in engines], 2))
    comparisons = tuple(
        compare(run, scene, traces[a, run], traces[b, run], tolerances)
        for run, scene in scenes.items()
        for a, b in pairs
        if (a, run) in traces and (b, run) in traces
    )
    executed = _Executed(design, instance, scenes, traces)
    verdicts = tuple(v for q in range(len(spec.questions)) for v in executed.verdicts(q, pairs, comparisons))
    return CheckResult(
        spec.name, index, instance.factors, instance.nuisances, comparisons, verdicts, (*failures, *failed)
    )


def run_name(spec: TaskSpec, q: int, change: Counterfactual) -> str:
    """Return the name of a counterfactual's run: its name, with the question's number if there are several."""
    return change.name if len(spec.questions) == 1 else f"{change.name} ({q + 1})"


def runs(design: Design, instance: Instance) -> dict[str, Counterfactual | None]:
    """Return what is executed of an instance, by name: the truth, and the counterfactuals of all questions."""
    changes: dict[str, Counterfactual | None] = {TRUTH: None}
    for q, question in enumerate(design.spec.questions):
        changes |= {run_name(design.spec, q, change): change for change in _changes(question, design, instance)}
    return changes


def _changes(question: Question, design: Design, instance: Instance) -> tuple[Counterfactual, ...]:
    """Return the counterfactuals and what-ifs that a question executes."""
    options = KINDS[question.kind].executed(question, instance.factors)
    return options + what_ifs(question, values_of(design, instance))


def _scenes(design: Design, instance: Instance) -> tuple[dict[str, Scene], list[Failure]]:
    """Return the scenes to execute, by run, and those that cannot be built."""
    scenes, failures = {}, []
    for run, change in runs(design, instance).items():
        try:
            scenes[run] = _reader().of(values_of(design, instance, change))
        except WmsError as error:
            failures.append(Failure("", run, str(error)))
    return scenes, failures


def _execute(scenes: Mapping[str, Scene], engines: Iterable[TraceCache]) -> tuple[Traces, list[Failure]]:
    traces, failures = {}, []
    for executed in engines:
        for run, scene in scenes.items():
            try:
                traces[executed.engine, run] = executed.trace(scene)
            except WmsError as error:
                failures.append(Failure(executed.engine, run, str(error)))
    return traces, failures


@dataclass(frozen=True)
class _Executed:
    """An executed instance with its questions."""

    design: Design
    instance: Instance
    scenes: Mapping[str, Scene]
    traces: Traces

    def verdicts(self, q: int, pairs: Sequence[Pair], comparisons: Sequence[Comparison]) -> list[Verdict]:
        """Return a question's verdict for every pair of engines that executed its runs."""
        spec, question = self.design.spec, self.design.spec.questions[q]
        runs = {TRUTH, *(run_name(spec, q, change) for change in _changes(question, self.design, self.instance))}
        answers = {
            engine: self._answer(q, engine)
            for engine in dict.fromkeys(engine for pair in pairs for engine in pair)
            if all((engine, run) in self.traces for run in runs)
        }
        verdicts = []
        for pair in pairs:
            if all(engine in answers for engine in pair):
                compared = [c for c in comparisons if c.engines == pair and c.run in runs]
                verdicts.append(_verdict(q, question, pair, (answers[pair[0]], answers[pair[1]]), compared))
        return verdicts

    def _answer(self, q: int, engine: str) -> EngineAnswer:
        spec, question = self.design.spec, self.design.spec.questions[q]

        def under(change: Counterfactual) -> Run:
            return self._run(engine, run_name(spec, q, change), change, under)

        pair = EnginePair(TraceCache(engine), _renders(engine))
        return answer(QuestionContext(question, self._run(engine, TRUTH, None, under), pair))

    def _run(
        self, engine: str, name: str, change: Counterfactual | None, under: Callable[[Counterfactual], Run]
    ) -> Run:
        """Return an executed run as the questions read it."""
        values = values_of(self.design, self.instance, change)
        return Run(values, self.scenes[name], self.traces[engine, name], under)


def _verdict(
    q: int, question: Question, pair: Pair, answers: tuple[EngineAnswer, EngineAnswer], compared: Sequence[Comparison]
) -> Verdict:
    a, b = answers
    agreed = agree(a, b)
    return Verdict(
        question=q,
        kind=question.kind,
        sort=question.sort,
        engines=pair,
        answers=(a.words, b.words),
        rejected=(a.rejected, b.rejected),
        agree=agreed,
        detail=difference(a, b, pair),
        cause=None if agreed else _cause(compared),
        regimes=tuple(dict.fromkeys(regime for c in compared for regime in c.regimes)),
    )


@cache
def _reader() -> SceneCache:
    """Return the cache that reads each scene of a closed set once."""
    return SceneCache()


@cache
def _renders(engine: str) -> RenderCache:
    """Return the renderer for measurements on pictures; renderers are created on first use."""
    return RenderCache(engine, MEASUREMENT_SIZE, MEASUREMENT_SIZE)


def _cause(comparisons: Sequence[Comparison]) -> Cause | None:
    """Return the cause of a different answer: the truth's, else that of the most divergent counterfactual."""
    parted = [c for c in comparisons if c.cause is not None]
    worst = max(
        parted,
        key=lambda c: (c.run == TRUTH, max((g.position / g.allowed for g in c.gaps), default=0.0)),
        default=None,
    )
    return worst.cause if worst else None
