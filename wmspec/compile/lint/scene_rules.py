"""Rules on the scene of an instance: overlaps, blind cameras, late actions."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

from wmspec.compile.design.depend import Dependencies
from wmspec.compile.design.design import Design, Instance
from wmspec.compile.design.levels import format_instance
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import all_pieces, touchable
from wmspec.compile.layout.view import camera_direction, common_direction
from wmspec.compile.lint.coplanar import coplanar_faces
from wmspec.compile.lint.overlap import overlaps
from wmspec.compile.lint.question_rules import answer_picture_time, is_posed
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.visibility import blind_cameras
from wmspec.compile.stage.object_cache import ObjectCache
from wmspec.core.diagnostics import Note
from wmspec.core.places import Location
from wmspec.lang.check.expressions.measured import is_measured
from wmspec.lang.check.ir.evaluate import NoValue, evaluate, subexpressions
from wmspec.lang.check.ir.ir import Call, Expr, Question
from wmspec.lang.check.tables.verbs import VERBS
from wmspec.lang.check.types import units

#: Computing time (s) per pair of objects and second of episode, from 150 falling spheres; warning threshold (s).
_PAIR_SECONDS, _MAX_SECONDS = 8e-4, 20.0
_CONTACTS = ("contact", "contact_time", "touches_first")


@dataclass(frozen=True)
class LintScene:
    """The values of an instance, with or without a counterfactual; `objects` caches prims of the task's scenes."""

    values: Evaluator
    depend: Dependencies
    design: Design
    instance: Instance
    objects: ObjectCache

    @property
    def where(self) -> str:
        """Text that names the instance in messages."""
        return format_instance(self.design, self.instance)


@rule("WMS601", "error")
def objects_inside_one_another(scene: LintScene) -> Iterator[Breach]:
    """Find objects that overlap at the start."""
    change = scene.values.change
    begun = f"under `{change.name}`" if change else "at the start"
    for pair in overlaps(scene.values):
        depth = units.format_quantity(float(f"{pair.depth:.2g}"), units.LENGTH)
        place = scene.values.source_location(pair.second)
        if of := _set_of(scene.values, pair.first, pair.second):
            what = f"members of `{of}` are {depth} inside one another {begun} {scene.where}"
            remedy = "say with `index` where each is, as in `at (index * 10 cm, 0)`, or make them smaller"
            yield Breach(what, place, remedy, about=of)
            continue
        what = f"`{pair.second}` is {depth} inside `{pair.first}` {begun} {scene.where}"
        note = Note(f"`{pair.first}` is declared here", scene.values.source_location(pair.first))
        remedy = "move them apart, make one smaller, or exclude this with `require`"
        yield Breach(what, place, remedy, (note,), (pair.first, pair.second))


def _set_of(values: Evaluator, first: str, second: str) -> str:
    """Return the set that contains both members, or an empty string."""
    sets = {values.spec.thing(name).set for name in (first, second)}
    return sets.pop() if len(sets) == 1 else ""


@rule("WMS602")
def blind_camera(scene: LintScene) -> Iterator[Breach]:
    """Find cameras without any relevant object in view."""
    for camera in blind_cameras(scene.values):
        what = f"`{camera}` shows no object that is moved or asked about"
        place = next(o.place for o in scene.values.spec.observations if o.camera == camera)
        yield Breach(what, place, "turn it with `look_at:`, widen its `fov:`, or leave it out", about=camera)


@rule("WMS609")
def faces_in_one_plane(scene: LintScene) -> Iterator[Breach]:
    """Find drawn faces in one plane: pictures show a random mixture of them, unlike in each engine."""
    for pair in coplanar_faces(scene.values):
        height = units.format_quantity(float(f"{pair.height:.4g}"), units.LENGTH)
        what = f"the tops of `{pair.first}` and `{pair.second}` lie in one plane, {height} high {scene.where}"
        remedy = "raise or lower one of them by a millimetre, so that all engines show the same of the two"
        note = Note(f"`{pair.first}` is declared here", scene.values.source_location(pair.first))
        place = scene.values.source_location(pair.second)
        yield Breach(what, place, remedy, (note,), (pair.first, pair.second))


@rule("WMS603")
def turned_camera(scene: LintScene) -> Iterator[Breach]:
    """Find cameras whose left differs from the left of `relation`."""
    spec = scene.values.spec
    answers = (part for question in spec.questions for part in subexpressions(question.answer))
    if not any(isinstance(part, Call) and part.function == "relation" and not _names_viewer(part) for part in answers):
        return
    way = common_direction(scene.values)
    for observation in spec.observations:
        if camera_direction(scene.values, observation.camera) != way:
            what = f"`{observation.camera}` looks another way than `relation`, which goes by the world's front"
            remedy = f"observe only from one side, or name the viewer: `seen_from: {observation.camera}`"
            yield Breach(what, observation.place, remedy, about=observation.camera)


def _names_viewer(relation: Call) -> bool:
    """Whether a relation names its viewer."""
    return any(option.name == "seen_from" for option in relation.options)


@rule("WMS304")
def late_action(scene: LintScene) -> Iterator[Breach]:
    """Find actions that start after the end of the episode."""
    values = scene.values
    end = values.end
    for action in values.spec.things:
        if action.kind == "action" and not (action.of or VERBS[action.verb].holds) and values.is_present(action.name):
            start = values.number(action.name, "start")
            if start > end - 1e-9:
                lasts = f"the episode lasts {units.format_quantity(end, units.TIME)} {scene.where}"
                begins = units.format_quantity(start, units.TIME)
                what = f"`{action.name}` never happens: it begins at {begins}, and {lasts}"
                remedy = "let it begin earlier, or set a longer `horizon`"
                yield Breach(what, values.source_location(action.name, "start"), remedy, about=action.name)


@rule("WMS304")
def too_many_contacts(scene: LintScene) -> Iterator[Breach]:
    """Find scenes with too many possible contacts: each step tests every pair, which makes episodes slow."""
    values = scene.values
    present = [t.name for t in values.spec.things if t.kind == "object" and values.is_present(t.name)]
    free = [name for name in present if not values.flag(name, "fixed")]
    pairs = len(free) * (len(free) - 1) // 2 + len(free) * (len(present) - len(free))
    seconds = pairs * values.end * _PAIR_SECONDS
    if seconds > _MAX_SECONDS:
        what = f"{len(free)} things can move, and {pairs:,} pairs can touch: an episode may take about {seconds:.0f} s"
        remedy = "have fewer, fix some of them, or observe for less long; `wmspec generate --timeout` gives more time"
        yield Breach(f"{what} {scene.where}", values.source_location(free[0]), remedy, about="crowded")


@rule("WMS304", "error")
def picture_after_the_end(scene: LintScene) -> Iterator[Breach]:
    """Find answers that are pictures after the end of the episode."""
    for question in scene.values.spec.questions:
        time = answer_picture_time(question, scene.values) if is_posed(question, scene.values) else None
        if time is not None and not scene.values.during(time):
            yield picture_outside(time, scene.values, question.place)


@rule("WMS304", "error")
def measure_outside_the_episode(scene: LintScene) -> Iterator[Breach]:
    """Find measurements outside the episode, or over an interval that ends before it begins."""
    values = scene.values
    for question in values.spec.questions:
        if not is_posed(question, values):
            continue
        for expr, place in _measured_expressions(question):
            for call in (part for part in subexpressions(expr) if isinstance(part, Call)):
                times = dict(_times(call, values))
                if late := [time for time in times.values() if not values.during(time)]:
                    lasts = (
                        f"the episode, which lasts {units.format_quantity(values.ref('end'), units.TIME)} {scene.where}"
                    )
                    what = f"`{call.function}` at {units.format_quantity(late[0], units.TIME)} is outside {lasts}"
                    yield Breach(what, place, "ask for an earlier time, or set a longer `horizon`")
                elif times.get("from", 0.0) >= times.get("to", math.inf):
                    what = f"the time of `{call.function}` ends before it begins {scene.where}"
                    yield Breach(what, place, "let `to` be later than `from`")


@rule("WMS506")
def contact_of_the_untouchable(scene: LintScene) -> Iterator[Breach]:
    """Find contacts with an object that nothing can touch: there are none."""
    values = scene.values
    for question in (question for question in values.spec.questions if is_posed(question, values)):
        for expr, place in _measured_expressions(question):
            calls = (part for part in subexpressions(expr) if isinstance(part, Call) and part.function in _CONTACTS)
            for name in (name for call in calls for name in _objects(call, values) if not _is_touchable(values, name)):
                what = f"nothing ever touches `{name}`, which is not solid {scene.where}"
                note = Note(f"`{name}` is declared here", values.source_location(name, "solid"))
                remedy = f"make `{name}` solid, or ask for a `distance` or `position`"
                yield Breach(what, place, remedy, (note,))


def _objects(call: Call, values: Evaluator) -> Iterator[str]:
    """Yield the objects among a function's arguments that are known before the episode."""
    for argument in (argument for argument in call.arguments if not is_measured(values.spec, argument)):
        with suppress(NoValue):
            named = evaluate(argument, values)
            yield from named if isinstance(named, tuple) else (named,)


def _is_touchable(values: Evaluator, name: str) -> bool:
    """Whether an object, or a part of it, can be touched."""
    return values.flag(name, "solid") and any(touchable(values, part) for part, _ in all_pieces(values, name))


def _measured_expressions(question: Question) -> Iterator[tuple[Expr, Location]]:
    """Yield the expressions of a question that are measured on the episode."""
    yield question.answer, question.place
    yield from ((ensure.condition, ensure.place) for ensure in question.ensures)
    yield from ((margin.value, margin.place) for margin in question.margins)
    if question.difference is not None:
        yield question.difference.value, question.place


def _times(call: Call, values: Evaluator) -> Iterator[tuple[str, float]]:
    """Yield the times (s) in a function's options that are known before the episode."""
    for option in call.options:
        if option.name in ("at", "from", "to") and not is_measured(values.spec, option.value):
            with suppress(NoValue):
                yield option.name, float(evaluate(option.value, values))


RULES = (
    objects_inside_one_another,
    faces_in_one_plane,
    blind_camera,
    turned_camera,
    late_action,
    too_many_contacts,
    picture_after_the_end,
    measure_outside_the_episode,
    contact_of_the_untouchable,
)


def picture_outside(time: float, values: Evaluator, place: Location) -> Breach:
    """Return the breach for a picture at a time (s) after the end of the episode."""
    lasts = f"the episode, which lasts {units.format_quantity(values.ref('end'), units.TIME)}"
    what = f"a picture at {units.format_quantity(time, units.TIME)} is outside {lasts}"
    return Breach(what, place, "ask for an earlier one, or set a longer `horizon`")
