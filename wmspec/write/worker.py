"""What a worker process does: ask one instance in every engine, and encode what comes of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from wmspec.ask.ask import ask
from wmspec.ask.consensus import Consensus, consensus
from wmspec.ask.model import QuestionRow, Rejected
from wmspec.ask.runs import EnginePair
from wmspec.check.record import from_json
from wmspec.design.design import Design
from wmspec.execute.render_cache import RenderCache
from wmspec.execute.trace_cache import TraceCache
from wmspec.scene.model import Look
from wmspec.write.rows import Row, encode


@dataclass(frozen=True)
class Job:
    """How every instance is made: `tasks` are `TaskSpec`s as JSON, by name."""

    tasks: tuple[tuple[str, str], ...]
    seed: int
    engines: tuple[str, ...]
    size: tuple[int, int]
    consensus: Consensus
    look: Look = "parity"
    samples: int | None = None
    renderer: str = ""


@dataclass(frozen=True)
class Outcome:
    """What came of one instance."""

    rows: tuple[Row, ...]
    rejected: tuple[Rejected, ...]


def work(job: Job, task: str, index: int) -> Outcome:
    """Ask an instance in every engine of the job."""
    design, pairs = _design(job, task), _pairs(job)
    answers = {engine: ask(design, index, pair) for engine, pair in pairs.items()}
    rows: list[Row] = []
    rejected: list[Rejected] = []
    for q in range(len(design.spec.questions)):
        one: dict[str, QuestionRow | Rejected] = {engine: questions[q] for engine, questions in answers.items()}
        for answer in consensus(one, job.consensus).values():
            if isinstance(answer, Rejected):
                rejected.append(answer)
            else:
                rows.append(encode(answer))
    return Outcome(tuple(rows), tuple(rejected))


@cache
def _design(job: Job, task: str) -> Design:
    return Design(from_json(dict(job.tasks)[task]), job.seed)


@cache
def _pairs(job: Job) -> dict[str, EnginePair]:
    return {
        engine: EnginePair(TraceCache(engine), RenderCache(job.renderer or engine, *job.size, job.look, job.samples))
        for engine in job.engines
    }
