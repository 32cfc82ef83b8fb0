"""The films of closed sets: each member's film is drawn once, and every row refers to the films of its options."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from wmspec.compile.design.design import Design
from wmspec.core.diagnostics import WmsError
from wmspec.core.memoize import LRU
from wmspec.dataset.build.rows import Row
from wmspec.dataset.film import codec
from wmspec.dataset.film.distances import (
    Array,
    nearest_pixels,
    object_points,
    pairwise,
    point_distance,
    widths_of,
    working_size,
)
from wmspec.dataset.film.timing import FilmSettings, FilmTimes, film_times, shown_times
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Question, TaskSpec
from wmspec.lang.check.statements.possibility import VIOLATIONS
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.questions.kinds.pictures import PictureAnswer
from wmspec.runtime.questions.kinds.possible import PossibleAnswer
from wmspec.runtime.questions.model import TRUTH, QuestionRow, Reject
from wmspec.runtime.questions.runs import EnginePair, Run, execute
from wmspec.runtime.questions.views import views_of

#: Films that are closer (widths, see `film_distance`) cannot be distinguished.
MIN_APART = 0.4
#: Objects whose films differ less (widths) do not distinguish the films.
MIN_DIFFERENCE = 0.25
#: An object moves in a frame if it is this far (px of the working size) from where it was in the frame before.
MIN_STEP = 0.5


def has_film(spec: TaskSpec, question: Question) -> bool:
    """Whether a question has films: of the options of a closed set, or of an episode that may be impossible."""
    return question.has_closed_pictures or (question.asks_possible and spec.film is not None)


def film_path(task: str, block: int, engine: str, index: int, suffix: str = ".mkv") -> str:
    """Return the path of a member's film in the dataset folder."""
    return f"films/{task}/{block}_{engine}/{index}{suffix}"


@dataclass
class FilmSet:
    """The film columns of one row, and the files that it refers to, by path."""

    columns: Row
    files: dict[str, bytes] = field(default_factory=dict)


class GroupFilms:
    """Draws the films of a design's closed sets; films that several rows refer to are drawn once.

    `pairs` are the engines; the engine of a row has whole films. With `others`, the other engines have films of the
    futures, in half the size.
    """

    def __init__(
        self,
        design: Design,
        pairs: Mapping[str, EnginePair],
        settings: FilmSettings,
        renderer: str,
        others: bool,
    ) -> None:
        self._design, self._pairs, self._settings, self._others = design, pairs, settings, others
        width, height = settings.size
        self._full = _renders(renderer, width, height)
        self._half = _renders(renderer, width // 4 * 2, height // 4 * 2)
        self._films: dict[object, DrawnFilm] = {}

    def has_films(self, row: QuestionRow) -> bool:
        """Whether a row has a closed set of pictures, and so of films."""
        return has_film(self._design.spec, self._design.spec.questions[row.question])

    def of(self, row: QuestionRow) -> FilmSet:
        """Return the films of a row. Raises Reject if two cannot be distinguished, or if they have no common times."""
        try:
            return self._of(row)
        except WmsError as error:
            raise Reject("invalid", f"film: {error.portable}") from None

    def _of(self, row: QuestionRow) -> FilmSet:
        answer = row.evidence
        design = self._design.redrawn(row.redrawn or 0)
        if isinstance(answer, PossibleAnswer):
            return self._whole(design, row)
        assert isinstance(answer, PictureAnswer)
        members = self._members(design, row)
        films = [self._film(design, index, row.engine, answer) for index in members]
        own = films[members.index(row.index)]
        _require_equal_times(films)
        objects = _distinguishing_objects(films)
        points = [_futures(film, objects) for film in films]
        apart = pairwise(points, widths_of([_areas(film, objects) for film in films])) if objects else None
        _require_apart(row, apart)
        paths = [film_path(row.task, row.block, row.engine, index) for index in members]
        made = FilmSet(self._columns(row, answer.camera, own, objects, apart, paths))
        for index, path, film in zip(members, paths, films, strict=True):
            made.files[path] = film.content
            made.files[film_path(row.task, row.block, row.engine, index, ".ids.mkv")] = film.ids
        for engine in (name for name in self._pairs if self._others and name != row.engine):
            self._add_futures(design, row, engine, members, made)
        return made

    def _whole(self, design: Design, row: QuestionRow) -> FilmSet:
        """Return the film of a row with `answer possible`; all of it is shown."""
        film = design.spec.film
        assert film is not None
        key = design, row.index, row.engine, film.camera
        if key not in self._films:
            pair = self._pairs[row.engine]
            run = execute(design, design[row.index], None, pair)
            times = _whole_times(run, self._settings.rate)
            self._films[key] = draw_film(run, film.camera, times, self._settings.rate, pair, self._full)
        own = self._films[key]
        path = film_path(row.task, row.block, row.engine, row.index)
        columns = self._columns(row, film.camera, own, list(own.objects), None, [])
        ids = film_path(row.task, row.block, row.engine, row.index, ".ids.mkv")
        return FilmSet(columns, {path: own.content, ids: own.ids})

    def _members(self, design: Design, row: QuestionRow) -> list[int]:
        """Return the instance of each option, in the order of the options."""
        question, instance = design.spec.questions[row.question], design[row.index]
        levels = {change.name: change.levels for change in question.counterfactuals}
        members = []
        for option in row.options:
            changed = {} if option.name == TRUTH else levels[option.name]
            index = design.index({**instance.factors, **changed}, instance.block)
            assert index is not None  # a closed set lies within its group
            members.append(index)
        return members

    def _film(self, design: Design, index: int, engine: str, answer: PictureAnswer) -> DrawnFilm:
        key = design, index, engine, answer.camera, answer.time
        if key not in self._films:
            pair = self._pairs[engine]
            run = execute(design, design[index], None, pair)
            times = _times(run, answer, self._settings)
            run = _continued(run, times.times[-1], pair)
            self._films[key] = draw_film(run, answer.camera, times, self._settings.rate, pair, self._full)
        return self._films[key]

    def _add_futures(self, design: Design, row: QuestionRow, engine: str, members: list[int], made: FilmSet) -> None:
        """Add the futures of another engine, if it executes all members."""
        answer, pair = row.evidence, self._pairs[engine]
        assert isinstance(answer, PictureAnswer)
        drawn: dict[str, bytes] = {}
        for index in members:
            key = design, index, engine, answer.camera, answer.time, "future"
            if key not in self._films:
                try:
                    run = execute(design, design[index], None, pair)
                except Reject:
                    return
                whole = _times(run, answer, self._settings)
                run = _continued(run, whole.times[-1], pair)
                times = FilmTimes(
                    whole.times[whole.context - 1 :], 1, whole.answer_frame - whole.context + 1, whole.offset
                )
                self._films[key] = draw_film(run, answer.camera, times, self._settings.rate, pair, self._half)
            film = self._films[key]
            drawn[film_path(row.task, row.block, engine, index)] = film.content
            drawn[film_path(row.task, row.block, engine, index, ".ids.mkv")] = film.ids
        made.files |= drawn
        made.columns["film_engines"].append(engine)

    def _columns(
        self,
        row: QuestionRow,
        camera: str,
        own: DrawnFilm,
        objects: list[str],
        apart: Array | None,
        paths: list[str],
    ) -> Row:
        width, height = working_size(*self._settings.size)
        return {
            "film": film_path(row.task, row.block, row.engine, row.index),
            "film_camera": camera,
            "film_rate": self._settings.rate,
            "film_start": own.times.times[0],
            "film_context": own.times.context,
            "film_answer": own.times.answer_frame,
            "film_offset": own.times.offset,
            "film_moving": _moving_frames(own),
            "film_text": row.film_text or model_text(row.text),
            "action_text": row.action_text,
            "film_bodies": list(own.bodies),
            "film_objects": objects,
            "film_engines": [],
            "option_film": paths,
            "film_split": own.times.split,
            "film_apart": [] if apart is None else [float(value) for value in apart.ravel()],
            "film_track": _track(own, objects, width, height),
        }


def _renders(renderer: str, width: int, height: int) -> RenderCache:
    """Return the renderer of films of one size, shared by the groups that a process makes."""
    options = (renderer, width, height)
    return _renderers.get(options, lambda: RenderCache(*options, remembered=1))


#: The two sizes of films that were drawn last.
_renderers: LRU[tuple[str, int, int], RenderCache] = LRU(2, drop=RenderCache.close)


def _continued(run: Run, until: float, pair: EnginePair) -> Run:
    """Return an execution that goes on until a time (s), if it ends before. Raises Reject if the engine fails."""
    if until <= run.scene.duration:
        return run
    scene = replace(run.scene, duration=until)
    try:
        return replace(run, scene=scene, trace=pair.traces.trace(scene))
    except WmsError as error:
        raise Reject("unstable", f"after the answer: {error.portable}") from None


def _times(run: Run, answer: PictureAnswer, settings: FilmSettings) -> FilmTimes:
    """Return the frames of an execution: from the start of the film, through the last look, to the answer or later."""
    spec, values = run.values.spec, run.values
    film = spec.film
    start = evaluate(film.start, values) if film is not None and film.start is not None else 0.0
    if film is not None and film.end is not None:
        last = evaluate(film.end, values)
    else:
        looks = [time for _, time in views_of(spec, values) if time < answer.time]
        last = max(looks, default=0.0)
    return film_times(start, last, answer.time, settings.rate, settings.seconds)


def _whole_times(run: Run, rate: int) -> FilmTimes:
    """Return the frames of a film that is shown whole, split at the first action that may break the laws of physics."""
    spec, values = run.values.spec, run.values
    film = spec.film
    assert film is not None
    start = 0.0 if film.start is None else evaluate(film.start, values)
    last = max(time for _, time in views_of(spec, values)) if film.end is None else evaluate(film.end, values)
    unlawful = {thing.name for thing in spec.things if thing.kind == "action" and thing.verb in VIOLATIONS}
    begins = [action.start for action in run.scene.actions if action.name in unlawful]
    return shown_times(start, last, min(begins, default=(start + last) / 2), rate)


def _require_equal_times(films: list[DrawnFilm]) -> None:
    ends = {(round(f.times.times[f.times.context - 1], 6), len(f.times.times) - f.times.context) for f in films}
    if len(ends) > 1:
        raise Reject("invalid", "film: the contexts of the closed set end at different times")


def _futures(film: DrawnFilm, objects: list[str]) -> Array:
    """Return the points of objects after the context, up to the answer."""
    which = [film.objects.index(name) for name in objects]
    return film.points[which][:, film.times.context : film.times.answer_frame + 1]


def _areas(film: DrawnFilm, objects: list[str]) -> Array:
    return film.areas[[film.objects.index(name) for name in objects]]


def _distinguishing_objects(films: list[DrawnFilm]) -> list[str]:
    """Return the objects whose places differ between two of the films."""
    names = [name for name in films[0].objects if all(name in film.objects for film in films)]
    if not names:
        return []
    widths = widths_of([_areas(film, names) for film in films])
    places = [_futures(film, names) for film in films]
    gaps = [point_distance(a, b, widths).mean(axis=1) for a, b in combinations(places, 2)]
    far = np.max(gaps, axis=0) >= MIN_DIFFERENCE
    return [name for name, differs in zip(names, far, strict=True) if differs]


def _require_apart(row: QuestionRow, apart: Array | None) -> None:
    """Raise Reject if two films are closer than `MIN_APART`."""
    if apart is None:
        raise Reject("alike", "no object differs between the films")
    names = [option.name for option in row.options]
    for i, j in combinations(range(len(names)), 2):
        if apart[i, j] < MIN_APART:
            what = f"the films of {names[i]} and {names[j]} are {apart[i, j]:.2f} object widths apart"
            raise Reject("alike", f"{what}, {MIN_APART:g} required")


def _moving_frames(film: DrawnFilm) -> int:
    """Return the number of context frames in which an object has moved since the frame before."""
    middles = film.points[:, : film.times.context, 0]
    steps = np.linalg.norm(np.diff(middles, axis=1), axis=-1)
    return int((np.nan_to_num(steps) >= MIN_STEP).any(axis=0).sum())


def _track(film: DrawnFilm, objects: list[str], width: int, height: int) -> list[Row]:
    """Return the place of each object in each frame: in the world (m) and in the picture (shares)."""
    rows: list[Row] = []
    for name in objects:
        k = film.objects.index(name)
        for frame in range(film.times.answer_frame + 1):
            x, y, z = (_number(value) for value in film.centers[k, frame])
            across, down = film.points[k, frame, 0] / (width, height)
            share = float(film.areas[k, frame]) / (width * height)
            place = {"x": x, "y": y, "z": z, "across": _number(across), "down": _number(down), "share": share}
            rows.append({"name": name, "frame": frame, **place})
    return rows


def _number(value: float) -> float | None:
    return None if np.isnan(value) else float(value)


_SENTENCE = re.compile(r"[^.!?]+(?:\.\d[^.!?]*)*[.!?]+\s*")
_OF_PICTURES = re.compile(r"\bpictures?\b", re.IGNORECASE)


def model_text(question: str) -> str:
    """Return the sentences of a question that neither ask nor speak of pictures."""
    sentences = [match[0].strip() for match in _SENTENCE.finditer(question)]
    return " ".join(s for s in sentences if not s.endswith("?") and not _OF_PICTURES.search(s))


@dataclass(frozen=True)
class DrawnFilm:
    """A film: encoded frames and ids, and what its objects do.

    `objects` are the spec's objects that can move. `points` (n, T, 3, 2) px and `areas` (n, T) px locate them in the
    working size, `centers` (n, A, 3) m in the world, up to the frame of the answer; NaN while absent. `bodies` are the
    names of all bodies.
    """

    content: bytes
    ids: bytes
    times: FilmTimes
    objects: tuple[str, ...]
    points: Array
    areas: Array
    centers: Array
    bodies: tuple[str, ...]


def draw_film(run: Run, camera: str, times: FilmTimes, rate: int, pair: EnginePair, renders: RenderCache) -> DrawnFilm:
    """Draw every frame of an execution. Raises GraphicsError if the engine cannot draw."""
    pair = replace(pair, renders=renders)
    frames = [run.draw(camera, time, pair) for time in times.times]
    rgb, ids = np.stack([frame.rgb for frame in frames]), np.stack([frame.ids for frame in frames])
    bodies = tuple(body.name for body in run.scene.bodies)
    things = {thing.name for thing in run.values.spec.things if thing.kind == "object"}
    objects = tuple(name for name in run.movable() if name in things)
    small = nearest_pixels(ids, working_size(*renders.size))
    points, areas = object_points(small, [bodies.index(name) for name in objects])
    shown = times.times[: times.answer_frame + 1]
    centers = np.stack([run.poses(objects, time)[:, :3] for time in shown], axis=1)
    return DrawnFilm(
        codec.encode(rgb, rate), codec.encode_ids(ids, rate), times, objects, points, areas, centers, bodies
    )
