"""The work of a worker process: makes the questions of instances in every engine and encodes them."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import astuple, dataclass, field, replace
from functools import lru_cache, partial

from wmspec.compile.design.design import Design
from wmspec.core.memoize import LRU
from wmspec.dataset.build.rows import NO_FILM, Row, encode
from wmspec.dataset.film.group import FilmSet, GroupFilms
from wmspec.dataset.film.timing import FilmSettings
from wmspec.lang.check.ir.record import from_json
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.caches.scene_cache import SceneCache
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.engines.registry import quickest_renderer
from wmspec.runtime.questions.balance import balanced_batch
from wmspec.runtime.questions.closed_sets import Answers, drop_incomplete_groups, has_closed_set
from wmspec.runtime.questions.consensus import Consensus, RowsOf
from wmspec.runtime.questions.cross_validation import CrossValidation
from wmspec.runtime.questions.model import QuestionRow, Reject, Rejected
from wmspec.runtime.questions.runs import EnginePair
from wmspec.sim.scene.model import Look


@dataclass(frozen=True)
class Job:
    """The settings of all instances: `tasks` are `TaskSpec`s as JSON, by name; some are megabytes."""

    tasks: tuple[tuple[str, str], ...]
    seed: int
    engines: tuple[str, ...]
    size: tuple[int, int]
    consensus: Consensus
    look: Look = "parity"
    samples: int | None = None
    renderer: str = ""
    rows_of: RowsOf = "questions"
    film: FilmSettings | None = None

    def of(self, task: str) -> Job:
        """Return the settings restricted to one task, which are sent with every batch."""
        return replace(self, tasks=tuple(pair for pair in self.tasks if pair[0] == task))


@dataclass(frozen=True)
class Outcome:
    """The rows and rejections of one instance; `films` are the SHA-256 of the films that its rows refer to, by path."""

    rows: tuple[Row, ...]
    rejected: tuple[Rejected, ...]
    films: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class CacheStats:
    """Cache statistics: episodes and pictures requested, executed and rendered."""

    episodes: int = 0
    executed: int = 0
    pictures: int = 0
    drawn: int = 0

    def __add__(self, other: CacheStats) -> CacheStats:
        return CacheStats(*map(sum, zip(astuple(self), astuple(other), strict=True)))

    def __str__(self) -> str:
        return (
            f"{self.executed:,} episodes executed where {self.episodes:,} were needed, "
            f"{self.drawn:,} pictures drawn where {self.pictures:,} were"
        )


@dataclass(frozen=True)
class Balance:
    """The cost of balancing answers: groups executed and groups kept."""

    executed: int = 0
    kept: int = 0

    def __add__(self, other: Balance) -> Balance:
        return Balance(self.executed + other.executed, self.kept + other.kept)

    def __str__(self) -> str:
        each = f" ({self.executed / self.kept:.1f} for each)" if self.kept else ""
        return f"answers are balanced, for which {self.executed:,} groups were executed and {self.kept:,} kept{each}"


@dataclass(frozen=True)
class BatchResult:
    """The outcomes of instances in order, the cache statistics, the balancing cost, and the films by path."""

    outcomes: tuple[Outcome, ...]
    shared: CacheStats = field(default_factory=CacheStats)
    balance: Balance = field(default_factory=Balance)
    films: Mapping[str, bytes] = field(default_factory=dict)


def make_instances(job: Job, task: str, indices: tuple[int, ...]) -> BatchResult:
    """Make instances with the engines of the job: one instance, or members of a group with a closed set.

    Such a group is made as a whole, whichever members are requested. The same holds for a batch of groups whose answers
    are balanced.
    """
    design, before = _design(job, task), _cache_counters(job)
    block, balance = design.blocks.locate(indices[0])[0], Balance()
    if design.spec.plan.balance:
        lap = balanced_batch(design, block, partial(_group, job))
        answers, balance = lap.answers, Balance(lap.executed, lap.kept)
    elif has_closed_set(design.spec):
        answers = _group(job, design, block)
    else:
        answers = {index: _answers(job, design, index) for index in indices}
    filming = None
    if job.film:
        renderer = job.renderer or quickest_renderer(job.engines)  # that of the pictures, if it draws them all
        filming = GroupFilms(design, _pairs(job), job.film, renderer, job.rows_of == "questions")
    films: dict[str, bytes] = {}
    outcomes = tuple(_outcome(answers[index], job.rows_of, filming, films) for index in indices)
    after = _cache_counters(job)
    return BatchResult(outcomes, CacheStats(*(b - a for a, b in zip(before, after, strict=True))), balance, films)


def _group(job: Job, design: Design, block: int) -> Mapping[int, Answers]:
    """Return the answers of all members of a group."""
    answers = {member: _answers(job, design, member) for member in design.blocks.members(block)}
    return drop_incomplete_groups(design.spec, answers) if has_closed_set(design.spec) else answers


def _cache_counters(job: Job) -> tuple[int, ...]:
    """Return the cache counters of this process's engines."""
    pairs = _pairs(job).values()
    renders = {id(pair.renders): pair.renders for pair in pairs}.values()  # engines may share one
    return (
        sum(pair.traces.requests for pair in pairs),
        sum(pair.traces.executed for pair in pairs),
        sum(render.requests for render in renders),
        sum(render.drawn for render in renders),
    )


def _answers(job: Job, design: Design, index: int) -> Answers:
    """Return the questions of an instance, filtered by the consensus setting of the job."""
    validation = CrossValidation(design, index, _pairs(job), job.consensus)
    return validation.questions() if job.rows_of == "questions" else validation.rows()


def _outcome(answers: Answers, rows_of: RowsOf, filming: GroupFilms | None, films: dict[str, bytes]) -> Outcome:
    """Encode the questions of an instance; films are added to `films`."""
    rows, rejected, own = list[Row](), list[Rejected](), dict[str, str]()
    for answer in answers:
        if isinstance(answer, Rejected):
            rejected.append(answer)
            continue
        try:
            film = _film_set(answer, filming)
        except Reject as reject:
            rejected.append(_unfilmed(answer, reject))
            continue
        rows.append(encode(answer, rows_of, None if film is None else film.columns))
        if film is not None:
            films |= film.files
            own |= {path: hashlib.sha256(content).hexdigest() for path, content in film.files.items()}
    return Outcome(tuple(rows), tuple(rejected), own)


def _film_set(row: QuestionRow, filming: GroupFilms | None) -> FilmSet | None:
    """Return the films of a row; empty columns for a question without a closed set of pictures."""
    if filming is None:
        return None
    return filming.of(row) if filming.has_films(row) else FilmSet(dict(NO_FILM))


def _unfilmed(row: QuestionRow, why: Reject) -> Rejected:
    return Rejected(row.task, row.index, row.question, row.engine, why.reason, why.detail, row.label)


@lru_cache(maxsize=4)
def _design(job: Job, task: str) -> Design:
    return Design(from_json(dict(job.tasks)[task]), job.seed)


def _pairs(job: Job) -> dict[str, EnginePair]:
    """Return the engines of a job with their caches; those of the job before are closed."""
    options = (job.engines, job.renderer, job.size, job.look, job.samples)
    return _engines.get(options, lambda: _new_pairs(*options))


def _new_pairs(
    engines: tuple[str, ...], renderer: str, size: tuple[int, int], look: Look, samples: int | None
) -> dict[str, EnginePair]:
    scenes = SceneCache()
    renders = {drawer: RenderCache(drawer, *size, look, samples) for drawer in ([renderer] if renderer else engines)}
    return {engine: EnginePair(TraceCache(engine), renders[renderer or engine], scenes) for engine in engines}


def _close(pairs: dict[str, EnginePair]) -> None:
    for pair in pairs.values():
        pair.renders.close()


_engines: LRU[tuple[object, ...], dict[str, EnginePair]] = LRU(1, drop=_close)
