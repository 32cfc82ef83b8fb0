"""Questions of a dataset as models receive them, with their control groups."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.rng import bits
from wmspec.dataset.build.films import ShownFilm, shown_film
from wmspec.dataset.build.images import as_png
from wmspec.dataset.build.reader import PICTURES, DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.eval.models.splits import DEFAULT_SPLITS, Splits, factors_of

_COLUMNS = (
    "id", "task", "dimension", "question_name", "engine", "index", "block", "text", "option_text", "option_name",
    "answer", "answer_number", "answer_unit", "answer_within", "context_time", "context_camera",
)  # fmt: skip
_FILM_COLUMNS = (
    "film", "film_camera", "film_rate", "film_start", "film_context", "film_answer", "film_offset", "film_text",
    "option_film",
)  # fmt: skip


@dataclass(frozen=True)
class QuestionIdentity:
    """The names and numbers of a question in its dataset."""

    id: str
    task: str
    dimension: str
    name: str
    engine: str
    index: int
    block: int

    @property
    def group(self) -> str:
        """The control group: questions that share nuisances and so are statistically dependent."""
        return f"{self.task}/{self.block}"

    @property
    def columns(self) -> dict[str, str | int]:
        """The columns of results that identify the question."""
        return {
            "id": self.id,
            "task": self.task,
            "dimension": self.dimension,
            "question_name": self.name,
            "engine": self.engine,
            "index": self.index,
            "block": self.block,
            "group": self.group,
        }


@dataclass(frozen=True)
class Question(QuestionIdentity):
    """A question: pictures (PNG), options and truth.

    `options` are the words of each option, None for a picture, which is then in `pictures`; `names` identify their
    meaning. `answer` is the position of the true option. For an open question, without options, it is None, and a reply
    is right `within` of `number` (SI `unit`). `times` (s) and `cameras` are those of the pictures in `context`.
    """

    text: str
    context: tuple[bytes, ...]
    options: tuple[str | None, ...]
    names: tuple[str, ...]
    pictures: tuple[bytes, ...]
    answer: int | None
    number: float | None
    unit: str
    within: float | None
    times: tuple[float, ...] = ()
    cameras: tuple[str, ...] = ()
    film: ShownFilm | None = None

    @property
    def in_words(self) -> bool:
        """Whether the options are words."""
        return None not in self.options

    @property
    def open_answer(self) -> tuple[float | None, str | None, float | None]:
        """True number, unit and tolerance of an open question; None each if there are options."""
        return (None, None, None) if self.options else (self.number, self.unit, self.within)


@dataclass(frozen=True)
class Selection:
    """A selection of questions: tasks, engines, a split (all if empty), and a maximum number.

    A limit takes equal numbers of each task and engine, with the same instances in every engine, spread at random over
    each task. A higher limit takes a superset.
    """

    tasks: tuple[str, ...] = ()
    engines: tuple[str, ...] = ()
    limit: int | None = None
    split: str = ""
    splits: Splits = DEFAULT_SPLITS

    def repetition(self, dataset: DatasetReader) -> str:
        """Return a note if the dataset has a row for each engine, so that a question occurs several times; else ''."""
        times = len(self.engines or dataset.engines)
        if dataset.rows_of == "questions" or times < 2:
            return ""
        remedy = f"--engine {dataset.engines[0]} selects one row"
        return f"note: the dataset has a row for each engine, and each question is asked {times} times; {remedy}"

    def ids(self, dataset: DatasetReader) -> list[str]:
        """Return the ids of the questions in dataset order. Raises WmsError if a task or engine is missing."""
        for name in self.tasks:
            if name not in dataset.tasks:
                hint = suggestion(name, dataset.tasks)
                raise WmsError(f"the dataset has no task `{name}`; {hint}".rstrip("; "))
        dataset.require_engines(self.engines)
        splits = self.splits.of_dataset(dataset)
        if self.split and splits.whole not in ("", self.split):
            raise WmsError(f"--split {self.split}: the dataset is the split `{splits.whole}`")
        queues: dict[tuple[str, str], dict[str, str]] = {}
        for task in self.tasks or dataset.tasks:
            levels = factors_of(dataset, task) if self.split else {}
            for row in dataset.rows(task, ["id", "index", "question", "engine"]):
                if self.split and splits.of(task, *levels[row["id"]]) != self.split:
                    continue
                engine = row["engine"] if dataset.rows_of == "engines" else ""
                if not self.engines or engine in self.engines:
                    queues.setdefault((task, engine), {})[row["id"]] = f"{task}/{row['index']:06d}/q{row['question']}"
        everything = [id for queue in queues.values() for id in queue]
        if self.limit is None:
            return everything
        chosen = _interleave(list(queues.values()), self.limit)
        return [id for id in everything if id in chosen]

    def by_task(self, dataset: DatasetReader) -> dict[str, list[str]]:
        """Return the ids of the questions by task. Raises WmsError as `ids` does."""
        tasks: dict[str, list[str]] = {}
        for id in self.ids(dataset):
            tasks.setdefault(id.partition("/")[0], []).append(id)
        return tasks


def _interleave(queues: list[dict[str, str]], limit: int) -> set[str]:
    """Return the first of every shuffled queue, then the second, and so on.

    A queue maps ids to questions. The shuffle is by question, so that it is the same for every engine.
    """
    shuffled = [sorted(queue, key=lambda id: bits("limit", queue[id])) for queue in queues]
    turns = sorted((turn, queue) for queue, ids in enumerate(shuffled) for turn in range(len(ids)))
    return {shuffled[queue][turn] for turn, queue in turns[:limit]}


def questions(dataset: DatasetReader, ids: Collection[str], pictures: bool = True) -> Iterator[Question]:
    """Yield the questions with these ids in dataset order, few in memory at a time; much faster without `pictures`.

    Raises WmsError if a shard cannot be read.
    """
    expected = set(ids)
    films = _FILM_COLUMNS if dataset.film is not None else ()
    columns = (*_COLUMNS, *films, *(PICTURES if pictures else ()))
    tasks = {id.partition("/")[0] for id in expected}
    for task in dataset.tasks:
        if task in tasks:
            indices = {row["index"] for row in dataset.rows(task, ("id", "index")) if row["id"] in expected}
            for row in dataset.rows(task, columns, indices):
                if row["id"] in expected:
                    yield question(row, shown_film(dataset.folder, row))


def question(row: Row, film: ShownFilm | None = None) -> Question:
    """Return the question of a dataset row; without pictures if the row was read without them.

    Raises WmsError if a picture is damaged.
    """
    return Question(
        id=row["id"],
        task=row["task"],
        dimension=row["dimension"],
        name=row["question_name"] or "",
        engine=row["engine"],
        index=row["index"],
        block=row["block"],
        text=row["text"],
        context=tuple(as_png(picture["bytes"]) for picture in row.get("context") or ()),
        options=tuple(row["option_text"] or (None for _ in row["option_name"])),
        names=tuple(row["option_name"]),
        pictures=tuple(as_png(picture["bytes"]) for picture in row.get("option_image") or ()),
        answer=row["answer"],
        number=row["answer_number"],
        unit=row["answer_unit"] or "",
        within=row["answer_within"],
        times=tuple(row["context_time"]),
        cameras=tuple(row["context_camera"]),
        film=film,
    )
