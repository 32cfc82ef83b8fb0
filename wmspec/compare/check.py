"""One instance in several engines, with the counterfactuals that its picture questions need."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations

from wmspec.ask.runs import EnginePair, Run, values_of
from wmspec.check.ir import Counterfactual, Question, TaskSpec
from wmspec.compare.answers import Answer, agree, answer, told
from wmspec.compare.compare import compare
from wmspec.compare.model import TRUTH, Cause, Checked, Comparison, Failure, Pair, Verdict
from wmspec.compare.tolerance import Tolerances
from wmspec.design.design import Design, Instance
from wmspec.diagnostics import WmsError
from wmspec.execute.render_cache import RenderCache
from wmspec.execute.trace_cache import TraceCache
from wmspec.scene.model import Scene, Trace
from wmspec.stage.episode import document
from wmspec.stage.layers import compose
from wmspec.usd import read

#: The pictures on which `visible`, `occluded` and `contrast` are measured (px).
SIDE = 256

#: A trace by engine and run.
Traces = Mapping[tuple[str, str], Trace]


def check(design: Design, index: int, executors: Sequence[TraceCache], tolerances: Tolerances) -> Checked:
    """Execute an instance in every engine and compare each pair of them."""
    spec, instance = design.spec, design[index]
    scenes, failures = _scenes(spec, instance)
    traces, failed = _execute(scenes, executors)
    pairs = list(combinations([e.engine for e in executors], 2))
    comparisons = tuple(
        compare(run, scene, traces[a, run], traces[b, run], tolerances)
        for run, scene in scenes.items()
        for a, b in pairs
        if (a, run) in traces and (b, run) in traces
    )
    asking = _Asking(design, instance, scenes, traces)
    verdicts = tuple(verdict for q in range(len(spec.questions)) for verdict in asking.verdicts(q, pairs, comparisons))
    return Checked(spec.name, index, instance.factors, instance.nuisances, comparisons, verdicts, (*failures, *failed))


def run_name(spec: TaskSpec, q: int, change: Counterfactual) -> str:
    """What a counterfactual's run is called: its name, with the question's number if there are several."""
    return change.name if len(spec.questions) == 1 else f"{change.name} ({q + 1})"


def _scenes(spec: TaskSpec, instance: Instance) -> tuple[dict[str, Scene], list[Failure]]:
    """The scenes to execute, by run, and those that cannot be made."""
    changes: dict[str, Counterfactual | None] = {TRUTH: None}
    for q, question in enumerate(spec.questions):
        if question.sort == "picture":
            changes |= {run_name(spec, q, c): c for c in question.counterfactuals}
    scenes, failures = {}, []
    for run, change in changes.items():
        try:
            scenes[run] = read(compose(document(spec, instance, change)))
        except WmsError as error:
            failures.append(Failure("", run, str(error)))
    return scenes, failures


def _execute(scenes: Mapping[str, Scene], executors: Iterable[TraceCache]) -> tuple[Traces, list[Failure]]:
    traces, failures = {}, []
    for executor in executors:
        for run, scene in scenes.items():
            try:
                traces[executor.engine, run] = executor.trace(scene)
            except WmsError as error:
                failures.append(Failure(executor.engine, run, str(error)))
    return traces, failures


@dataclass(frozen=True)
class _Asking:
    """An executed instance whose questions are asked."""

    design: Design
    instance: Instance
    scenes: Mapping[str, Scene]
    traces: Traces

    def verdicts(self, q: int, pairs: Sequence[Pair], comparisons: Sequence[Comparison]) -> list[Verdict]:
        """A question in every pair of engines that executed what it needs."""
        spec, question = self.design.spec, self.design.spec.questions[q]
        runs = {TRUTH: TRUTH} | {
            c.name: run_name(spec, q, c) for c in question.counterfactuals if question.sort == "picture"
        }
        answers = {e: self._answer(question, e, runs) for e in dict.fromkeys(e for pair in pairs for e in pair)}
        found = []
        for pair in pairs:
            a, b = (answers[e] for e in pair)
            if a is None or b is None:
                continue
            agreed = agree(a, b)
            why = None if agreed else _cause([c for c in comparisons if c.engines == pair and c.run in runs.values()])
            rejected = (a.rejected, b.rejected)
            said = (a.said, b.said)
            found.append(Verdict(q, question.sort, pair, said, rejected, agreed, told(a, b, pair), why))
        return found

    def _answer(self, question: Question, engine: str, runs: Mapping[str, str]) -> Answer | None:
        if any((engine, run) not in self.traces for run in runs.values()):
            return None
        changes = {c.name: c for c in question.counterfactuals}
        made = {
            name: Run(
                values_of(self.design, self.instance, changes.get(name)), self.scenes[run], self.traces[engine, run]
            )
            for name, run in runs.items()
        }
        return answer(question, made, EnginePair(TraceCache(engine), _studio(engine)))


@cache
def _studio(engine: str) -> RenderCache:
    """Draws only for what is measured on pictures; it costs nothing where nothing is."""
    return RenderCache(engine, SIDE, SIDE)


def _cause(comparisons: Sequence[Comparison]) -> Cause | None:
    """Why the answer differs: the truth's own divergence, else that of the counterfactual that parts most."""
    parted = [c for c in comparisons if c.cause is not None]
    worst = max(
        parted,
        key=lambda c: (c.run == TRUTH, max((g.position / g.allowed for g in c.gaps), default=0.0)),
        default=None,
    )
    return worst.cause if worst else None
