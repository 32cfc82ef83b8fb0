"""Questions with films, and the films of their options."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Literal

from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.films import read_frames, read_ids
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.film.distances import working_size
from wmspec.eval.clips.reference import Reference, WholeFilm
from wmspec.eval.clips.sam2 import Tracker
from wmspec.eval.models.question import QuestionIdentity, Selection

_COLUMNS = (
    "id", "task", "dimension", "question_name", "engine", "index", "block", "option_name", "answer", "film",
    "film_rate", "film_context", "film_answer", "film_moving", "film_text", "action_text", "film_bodies",
    "film_objects", "film_engines", "option_film", "film_split",
)  # fmt: skip


@dataclass(frozen=True)
class FilmQuestion(QuestionIdentity):
    """A question with a closed set of films, or whether a film is possible.

    `context` is the number of frames shown, `answer_frame` that of the answer. `films` are the paths of the options'
    films, `objects` the names of the objects by which they differ, `engines` the other engines with films. A question
    whether a film is possible has no `films`; the first `split` frames of its film come before what may be impossible.
    """

    options: tuple[str, ...]
    answer: int
    film: str
    rate: int
    context: int
    answer_frame: int
    moving: int
    text: str
    action_text: str
    bodies: tuple[str, ...]
    objects: tuple[str, ...]
    engines: tuple[str, ...]
    films: tuple[str, ...]
    split: int = 0

    @property
    def file_name(self) -> str:
        """The name of the question's files, without a suffix."""
        return self.id.replace("/", "-")

    @property
    def own(self) -> int:
        """The option whose film the question shows the beginning of."""
        return self.films.index(self.film)

    def film_of(self, option: int, engine: str) -> str:
        """Return the path of an option's film in another engine."""
        folder, _, name = self.films[option].rpartition("/")
        return f"{folder.removesuffix(f'_{self.engine}')}_{engine}/{name}"


def film_questions(
    dataset: DatasetReader, ids: Collection[str], having: Literal["option_film", "film_split"] = "option_film"
) -> Iterator[FilmQuestion]:
    """Yield the questions with closed sets of films among these ids, or whether a film is possible (`film_split`).

    They are in dataset order. Raises WmsError for a dataset without films.
    """
    if dataset.film is None:
        raise WmsError(f"{dataset.folder} has no films", help="make it with `wmspec generate ... --film 24`")
    expected = set(ids)
    tasks = {id.partition("/")[0] for id in expected}
    for task in dataset.tasks:
        if task in tasks and dataset.columns(task):
            for row in dataset.rows(task, _COLUMNS):
                if row["id"] in expected and row.get(having):
                    yield _question(row)


def selected(dataset: DatasetReader, selection: Selection) -> list[FilmQuestion]:
    """Return the selected questions that have films; a limit counts these. Raises WmsError if there are none."""
    every = list(film_questions(dataset, Selection(selection.tasks, selection.engines).ids(dataset)))
    if not every:
        raise WmsError("none of the questions has films: they need a closed set of pictures (`options orbit of ...`)")
    return limited(dataset, every, selection)


def limited(dataset: DatasetReader, every: list[FilmQuestion], selection: Selection) -> list[FilmQuestion]:
    """Return as many of some questions as a selection has, from as few groups as possible."""
    if selection.limit is None:
        return every
    order = {id: place for place, id in enumerate(Selection(selection.tasks, selection.engines).ids(dataset))}
    spread = sorted(every, key=lambda q: (q.block, q.task, order[q.id]))[: selection.limit]
    return sorted(spread, key=lambda q: order[q.id])


def _question(row: dict[str, object]) -> FilmQuestion:
    def texts(name: str) -> tuple[str, ...]:
        return tuple(row[name])  # type: ignore[arg-type]

    return FilmQuestion(
        **{name: row[name] for name in ("id", "task", "dimension", "engine", "index", "block", "answer", "film")},  # type: ignore[arg-type]
        name=str(row["question_name"] or ""),
        **{name: row[f"film_{name}"] for name in ("rate", "context", "moving", "text")},  # type: ignore[arg-type]
        answer_frame=row["film_answer"],  # type: ignore[arg-type]
        action_text=str(row["action_text"] or ""),
        options=texts("option_name"),
        bodies=texts("film_bodies"),
        objects=texts("film_objects"),
        engines=texts("film_engines"),
        films=texts("option_film"),
        split=row.get("film_split") or 0,  # type: ignore[arg-type]
    )


def closed_sets(questions: list[FilmQuestion], most: int) -> list[list[FilmQuestion]]:
    """Return at most some closed sets, spread over a task; their questions have the same order of options."""
    sets: dict[tuple[str, ...], list[FilmQuestion]] = {}
    for question in questions:
        films = tuple(sorted(question.films))
        same = replace(question, films=films, answer=films.index(question.films[question.answer]))
        sets.setdefault(films, []).append(same)
    found = list(sets.values())
    count = min(most, len(found))
    return [found[i * len(found) // count] for i in range(count)]


# ---------------------------------------------------------------- films


def reference_of(dataset: DatasetReader, question: FilmQuestion, tracker: Tracker | None = None) -> Reference:
    """Return the films of a question's options in working size. Raises WmsError if a film is damaged."""
    assert dataset.film is not None
    size, count = working_size(*dataset.film.size), question.answer_frame + 1
    films = tuple(
        WholeFilm(
            read_frames(dataset.folder, path, size, count),
            read_ids(dataset.folder, path, size, count),
            question.context,
        )
        for path in question.films
    )
    bodies = tuple(question.bodies.index(name) for name in question.objects)
    return Reference(question.rate, films, bodies, tracker)
