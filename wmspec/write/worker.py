"""What a worker process does: ask instances in every engine, and encode what comes of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from wmspec.ask.ask import ask
from wmspec.ask.closed import Answers, has_closed, kept_whole
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


def work(job: Job, task: str, indices: tuple[int, ...]) -> tuple[Outcome, ...]:
    """Ask instances in every engine of the job: one, or some of a group whose options are a closed set.

    Such a group is asked as a whole, whichever of its members are wanted.
    """
    design = _design(job, task)
    if not has_closed(design.spec):
        return tuple(_outcome(_answers(job, design, index)) for index in indices)
    members = design.blocks.members(design.blocks.locate(indices[0])[0])
    whole = kept_whole(design.spec, {member: _answers(job, design, member) for member in members})
    return tuple(_outcome(whole[index]) for index in indices)


def made_with(job: Job, task: str, index: int) -> int:
    """How many instances are made where this one is wanted: itself, or its whole group."""
    design = _design(job, task)
    return len(design.blocks.members(design.blocks.locate(index)[0])) if has_closed(design.spec) else 1


def _answers(job: Job, design: Design, index: int) -> Answers:
    """What every engine answers, one question after the other, where they agree as far as the job wants."""
    asked = {engine: ask(design, index, pair) for engine, pair in _pairs(job).items()}
    answers: list[QuestionRow | Rejected] = []
    for q in range(len(design.spec.questions)):
        one: dict[str, QuestionRow | Rejected] = {engine: questions[q] for engine, questions in asked.items()}
        answers += consensus(one, job.consensus).values()
    return answers


def _outcome(answers: Answers) -> Outcome:
    rejected = tuple(answer for answer in answers if isinstance(answer, Rejected))
    return Outcome(tuple(encode(answer) for answer in answers if not isinstance(answer, Rejected)), rejected)


@cache
def _design(job: Job, task: str) -> Design:
    return Design(from_json(dict(job.tasks)[task]), job.seed)


@cache
def _pairs(job: Job) -> dict[str, EnginePair]:
    return {
        engine: EnginePair(TraceCache(engine), RenderCache(job.renderer or engine, *job.size, job.look, job.samples))
        for engine in job.engines
    }
