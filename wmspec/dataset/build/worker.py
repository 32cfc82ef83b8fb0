"""What a worker process does: ask instances in every engine, and encode what comes of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass, field, replace
from functools import cache, lru_cache, partial

from wmspec.compile.design.design import Design
from wmspec.dataset.build.rows import Row, encode
from wmspec.lang.check.ir.record import from_json
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.caches.scene_cache import SceneCache
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.questions.ask import ask
from wmspec.runtime.questions.balance import balanced
from wmspec.runtime.questions.closed_sets import Answers, has_closed, kept_whole
from wmspec.runtime.questions.consensus import Consensus, consensus
from wmspec.runtime.questions.model import QuestionRow, Rejected
from wmspec.runtime.questions.runs import EnginePair
from wmspec.sim.scene.model import Look


@dataclass(frozen=True)
class Job:
    """How every instance is made: `tasks` are `TaskSpec`s as JSON, by name; some are megabytes."""

    tasks: tuple[tuple[str, str], ...]
    seed: int
    engines: tuple[str, ...]
    size: tuple[int, int]
    consensus: Consensus
    look: Look = "parity"
    samples: int | None = None
    renderer: str = ""

    def of(self, task: str) -> Job:
        """The same for one task alone: what is sent with every piece of work."""
        return replace(self, tasks=tuple(pair for pair in self.tasks if pair[0] == task))


@dataclass(frozen=True)
class Outcome:
    """What came of one instance."""

    rows: tuple[Row, ...]
    rejected: tuple[Rejected, ...]


@dataclass(frozen=True)
class Sharing:
    """How often episodes and pictures were needed, and how many of them were executed and drawn."""

    episodes: int = 0
    executed: int = 0
    pictures: int = 0
    drawn: int = 0

    def __add__(self, other: Sharing) -> Sharing:
        return Sharing(*map(sum, zip(astuple(self), astuple(other), strict=True)))

    def __str__(self) -> str:
        return (
            f"{self.executed:,} episodes executed where {self.episodes:,} were needed, "
            f"{self.drawn:,} pictures drawn where {self.pictures:,} were"
        )


@dataclass(frozen=True)
class Balance:
    """What the balance of answers cost: the groups that were executed, and those of them that were kept."""

    executed: int = 0
    kept: int = 0

    def __add__(self, other: Balance) -> Balance:
        return Balance(self.executed + other.executed, self.kept + other.kept)

    def __str__(self) -> str:
        each = f" ({self.executed / self.kept:.1f} for each)" if self.kept else ""
        return f"answers are balanced, for which {self.executed:,} groups were executed and {self.kept:,} kept{each}"


@dataclass(frozen=True)
class Made:
    """What came of instances, in order, how much of the work was shared, and what balance cost."""

    outcomes: tuple[Outcome, ...]
    shared: Sharing = field(default_factory=Sharing)
    balance: Balance = field(default_factory=Balance)


def work(job: Job, task: str, indices: tuple[int, ...]) -> Made:
    """Ask instances in every engine of the job: one, or some of a group whose options are a closed set.

    Such a group is asked as a whole, whichever of its members are wanted; so is a lap of groups whose answers are
    balanced.
    """
    design, before = _design(job, task), _counted(job)
    block, balance = design.blocks.locate(indices[0])[0], Balance()
    if design.spec.plan.balance:
        lap = balanced(design, block, partial(_group, job))
        answers, balance = lap.answers, Balance(lap.executed, lap.kept)
    elif has_closed(design.spec):
        answers = _group(job, design, block)
    else:
        answers = {index: _answers(job, design, index) for index in indices}
    outcomes = tuple(_outcome(answers[index]) for index in indices)
    after = _counted(job)
    return Made(outcomes, Sharing(*(b - a for a, b in zip(before, after, strict=True))), balance)


def _group(job: Job, design: Design, block: int) -> Mapping[int, Answers]:
    """The answers of all members of a group."""
    answers = {member: _answers(job, design, member) for member in design.blocks.members(block)}
    return kept_whole(design.spec, answers) if has_closed(design.spec) else answers


def _counted(job: Job) -> tuple[int, ...]:
    """What was asked of this process's engines, and what they did."""
    counts = [(p.traces.asked, p.traces.executed, p.renders.asked, p.renders.drawn) for p in _pairs(job).values()]
    return tuple(map(sum, zip(*counts, strict=True)))


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


@lru_cache(maxsize=4)
def _design(job: Job, task: str) -> Design:
    return Design(from_json(dict(job.tasks)[task]), job.seed)


def _pairs(job: Job) -> dict[str, EnginePair]:
    return _engines(job.engines, job.renderer, job.size, job.look, job.samples)


@cache
def _engines(
    engines: tuple[str, ...], renderer: str, size: tuple[int, int], look: Look, samples: int | None
) -> dict[str, EnginePair]:
    scenes = SceneCache()
    return {
        engine: EnginePair(TraceCache(engine), RenderCache(renderer or engine, *size, look, samples), scenes)
        for engine in engines
    }
