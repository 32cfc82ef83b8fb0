"""The questions of a dataset as models are asked them, and the control group that each belongs to."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.rng import bits
from wmspec.dataset.build.pictures import as_png
from wmspec.dataset.build.reader import PICTURES, DatasetReader
from wmspec.dataset.build.rows import Row

_COLUMNS = (
    "id", "task", "dimension", "question_name", "engine", "index", "block", "text", "option_text", "option_name",
    "answer", "answer_number", "answer_unit", "answer_within",
)  # fmt: skip


@dataclass(frozen=True)
class Question:
    """A question: what is shown (pictures as PNG), its options, and the truth.

    `options` are the words of each, None for a picture, which `pictures` then has; `names` are what each stands for.
    `answer` is the place of the true option; of an open question, which has no options, it is None, and right is what
    is `within` of `number` (SI `unit`).
    """

    id: str
    task: str
    dimension: str
    name: str
    engine: str
    index: int
    block: int
    text: str
    context: tuple[bytes, ...]
    options: tuple[str | None, ...]
    names: tuple[str, ...]
    pictures: tuple[bytes, ...]
    answer: int | None
    number: float | None
    unit: str
    within: float | None

    @property
    def in_words(self) -> bool:
        """Whether the options are words."""
        return None not in self.options

    @property
    def group(self) -> str:
        """The control group: questions that share their nuisances and so are not independent of one another."""
        return f"{self.task}/{self.block}"


@dataclass(frozen=True)
class Selection:
    """Which questions of a dataset: of these tasks and engines, all without; and at most so many of them.

    A limit takes as many of each task and engine as of the others, the same instances in every engine, spread at random
    over each task; a higher one takes the same and more.
    """

    tasks: tuple[str, ...] = ()
    engines: tuple[str, ...] = ()
    limit: int | None = None

    def ids(self, dataset: DatasetReader) -> list[str]:
        """The questions' ids in the dataset's order. Raises WmsError if the dataset lacks a task or an engine."""
        for kind, wanted, known in (("task", self.tasks, dataset.tasks), ("engine", self.engines, dataset.engines)):
            for name in wanted:
                if name not in known:
                    raise WmsError(f"the dataset has no {kind} `{name}`; {suggestion(name, known)}".rstrip("; "))
        queues: dict[tuple[str, str], list[str]] = {}
        for task in self.tasks or dataset.tasks:
            for row in dataset.rows(task, ["id", "engine"]):
                if not self.engines or row["engine"] in self.engines:
                    queues.setdefault((task, row["engine"]), []).append(row["id"])
        everything = [id for queue in queues.values() for id in queue]
        if self.limit is None:
            return everything
        chosen = _evenly(list(queues.values()), self.limit)
        return [id for id in everything if id in chosen]


def _evenly(queues: list[list[str]], limit: int) -> set[str]:
    """The first of every queue, then the second, once they have been shuffled; whatever the engine the same way."""
    shuffled = [sorted(queue, key=lambda id: bits("limit", id.rpartition("/")[0])) for queue in queues]
    turns = sorted((turn, queue) for queue, ids in enumerate(shuffled) for turn in range(len(ids)))
    return {shuffled[queue][turn] for turn, queue in turns[:limit]}


def questions(dataset: DatasetReader, ids: Collection[str], pictures: bool = True) -> Iterator[Question]:
    """The questions of these ids, in the dataset's order, few in memory at a time; without `pictures` much quicker.

    Raises WmsError if a shard cannot be read.
    """
    wanted = set(ids)
    columns = (*_COLUMNS, *PICTURES) if pictures else _COLUMNS
    indices: dict[str, set[int]] = {}
    for id in wanted:
        task, index, *_ = id.split("/")
        indices.setdefault(task, set()).add(int(index))
    for task in dataset.tasks:
        if task in indices:
            for row in dataset.rows(task, ("index", *(c for c in columns if c != "index")), indices[task]):
                if row["id"] in wanted:
                    yield question(row)


def question(row: Row) -> Question:
    """The question of a dataset's row; without pictures if the row was read without them.

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
    )
