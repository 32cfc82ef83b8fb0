"""The plan of a dataset: everything that is known before the first question is made."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final

from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.splits import TEST, Split
from wmspec.dataset.film.timing import FilmSettings
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.runtime.questions.consensus import Consensus, RowsOf
from wmspec.sim.scene.model import Look

#: The version of the folder's layout and columns, of the order of instances, and of the ids of questions.
FORMAT = 3
#: The name of the count of rows, if there is one row a question.
QUESTIONS: Final = "questions"


@dataclass(frozen=True)
class Task:
    """A task and the indices of its instances, in row order.

    `selected` is the number of instances of which these are a share (see `Plan.part`); by default, of these.
    """

    spec: TaskSpec
    indices: tuple[int, ...]
    selected: int | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Shard:
    """Some instances of a task in one Parquet file, the `number`-th `of` all."""

    task: Task
    number: int
    of: int
    indices: tuple[int, ...]
    split: str = TEST

    @property
    def path(self) -> str:
        """The path in the dataset folder."""
        return f"data/{self.task.spec.name}/{self.split}-{self.number:05d}-of-{self.of:05d}.parquet"


@dataclass(frozen=True)
class Plan:
    """Everything that determines the bytes of a dataset.

    `texts` are the specs and the files they use, by name. `size` is the width and height of pictures (px); `look`
    and `samples` determine the rendering. `renderer` is the engine that renders all episodes; if empty, each engine
    renders its own. `consensus` says how many engines must agree. A row is one of `rows_of`: a question that the
    reference engine executed and the others confirm, or a question in each of the engines. `profile` names the
    benchmark whose questions have its format. `part` is (i, n) for share i of n of the instances. `shard` is the
    number of instances in a shard, `versions` those of wmspec and the engines. `film` are the settings of
    films, None for a dataset without. `split` is the split of which all instances are, if any. `licence` is stated
    in the card and has no other effect.

    Raises WmsError if two tasks have the same name.
    """

    texts: dict[str, str]
    tasks: tuple[Task, ...]
    engines: tuple[str, ...]
    size: tuple[int, int]
    seed: int
    consensus: Consensus
    versions: dict[str, str]
    look: Look = "parity"
    samples: int | None = None
    renderer: str = ""
    rows_of: RowsOf = "questions"
    profile: str = ""
    part: tuple[int, int] = (1, 1)
    shard: int = field(default=64)
    licence: str = ""
    film: FilmSettings | None = None
    split: Split | None = None

    def __post_init__(self) -> None:
        names = [t.spec.name.casefold() for t in self.tasks]
        for task in self.tasks:
            if names.count(task.spec.name.casefold()) > 1:
                raise WmsError(
                    f"two of the specs define a task `{task.spec.name}`; rename one, or write them to different folders"
                )
        if self.shard < 1:
            raise WmsError(f"a shard has at least one instance, not {self.shard}")

    @property
    def reference(self) -> str:
        """The engine that executes what is shown; the others confirm its answers."""
        return self.engines[0]

    @property
    def row_engines(self) -> tuple[str | None, ...]:
        """The engines of the rows of one question; None for the single row that stands for all engines."""
        return self.engines if self.rows_of == "engines" else (None,)

    @property
    def split_name(self) -> str:
        """The split of the files: `test` for a dataset that is not divided."""
        return self.split.name if self.split else TEST

    def shards(self) -> Iterator[Shard]:
        """Yield the shards of all tasks, in order."""
        for task in self.tasks:
            of = -(-len(task.indices) // self.shard)
            for number in range(of):
                indices = task.indices[number * self.shard : (number + 1) * self.shard]
                yield Shard(task, number, of, indices, self.split_name)

    @cached_property
    def record(self) -> dict[str, Any]:
        """The plan as JSON values."""
        return {
            "format": FORMAT,
            "versions": dict(sorted(self.versions.items())),
            "seed": self.seed,
            "engines": list(self.engines),
            "size": list(self.size),
            "look": self.look,
            "samples": self.samples,
            "renderer": self.renderer,
            "consensus": self.consensus,
            "rows_of": self.rows_of,
            **({"profile": self.profile} if self.profile else {}),
            **({"film": self.film.record} if self.film else {}),
            **({"split": self.split.record} if self.split else {}),
            "shard": self.shard,
            "specs": {name: hashlib.sha256(text.encode()).hexdigest() for name, text in sorted(self.texts.items())},
            "tasks": {t.spec.name: list(t.indices) for t in self.tasks},
        }

    @cached_property
    def fingerprint(self) -> str:
        """A hash that is equal for two plans exactly if they make the same dataset."""
        return fingerprint(self.record)


def row_names(rows_of: RowsOf, engines: Sequence[str]) -> tuple[str, ...]:
    """Return the names under which rows are counted: those of the engines if each has its own rows."""
    return tuple(engines) if rows_of == "engines" else (QUESTIONS,)


def fingerprint(record: dict[str, Any]) -> str:
    """Return the hash of a plan given as JSON values."""
    return hashlib.sha256(json.dumps(record, ensure_ascii=False).encode()).hexdigest()


def differences(there: dict[str, Any], here: dict[str, Any]) -> list[str]:
    """Return the differences of two plans (as JSON values), in words."""
    return [_differs(key, there.get(key), here[key]) for key in here if there.get(key) != here[key]]


def _words(value: Any) -> str:
    return "none" if value is None else " ".join(map(str, value)) if isinstance(value, list) else str(value).lower()


def _differs(key: str, there: Any, here: Any) -> str:
    if isinstance(here, dict) and isinstance(there, dict):
        names = [n for n in {**there, **here} if there.get(n) != here.get(n)]
        if key == "versions":
            return f"versions ({', '.join(_differs(n, there.get(n), here.get(n)) for n in names)})"
        what = "instances" if key == "tasks" and all(n in there and n in here for n in names) else key
        return f"{what} ({', '.join(names) or 'in another order'})"
    return f"{key} {_words(there)} there, {_words(here)} now"
