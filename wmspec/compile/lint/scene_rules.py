"""Rules on the scene of an instance: what is inside what, what is never seen, what never happens."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

from wmspec.compile.design.depend import Dependencies
from wmspec.compile.design.describe import told_of
from wmspec.compile.design.design import Design, Instance
from wmspec.compile.layout.values import Values
from wmspec.compile.layout.view import facing, front
from wmspec.compile.lint.overlap import overlaps
from wmspec.compile.lint.question_rules import asked, pictured
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.visibility import blind
from wmspec.core.diagnostics import Note
from wmspec.core.places import Location
from wmspec.lang.check.expressions.measured import measured
from wmspec.lang.check.ir.evaluate import NoValue, evaluate, parts
from wmspec.lang.check.ir.ir import Call, Expr, Question
from wmspec.lang.check.tables.verbs import VERBS
from wmspec.lang.check.types import units

#: What a pair of things takes for a second of an episode (s), measured with 150 falling spheres; and what is worth a
#: warning (s).
_PAIR_SECONDS, _LONG = 8e-4, 20.0


@dataclass(frozen=True)
class Scene:
    """The values of an instance, or of what it would be under a counterfactual."""

    values: Values
    depend: Dependencies
    design: Design
    instance: Instance

    @property
    def where(self) -> str:
        """Which instance, as messages tell it."""
        return told_of(self.design, self.instance)


@rule("WMS601", "error")
def objects_inside_one_another(scene: Scene) -> Iterator[Breach]:
    """Objects inside one another at the start."""
    change = scene.values.change
    begun = f"under `{change.name}`" if change else "at the start"
    for pair in overlaps(scene.values):
        depth = units.told(float(f"{pair.depth:.2g}"), units.LENGTH)
        place = scene.values.place(pair.second)
        if of := _set_of(scene.values, pair.first, pair.second):
            what = f"members of `{of}` are {depth} inside one another {begun} {scene.where}"
            remedy = "say with `index` where each is, as in `at (index * 10 cm, 0)`, or make them smaller"
            yield Breach(what, place, remedy, about=of)
            continue
        what = f"`{pair.second}` is {depth} inside `{pair.first}` {begun} {scene.where}"
        note = Note(f"`{pair.first}` is declared here", scene.values.place(pair.first))
        remedy = "move them apart, make one smaller, or exclude this with `require`"
        yield Breach(what, place, remedy, (note,), (pair.first, pair.second))


def _set_of(values: Values, first: str, second: str) -> str:
    """The set that both are members of; empty if there is none."""
    sets = {values.spec.thing(name).set for name in (first, second)}
    return sets.pop() if len(sets) == 1 else ""


@rule("WMS602")
def blind_camera(scene: Scene) -> Iterator[Breach]:
    """A camera that looks at nothing that matters."""
    for camera in blind(scene.values):
        what = f"`{camera}` has none of what is moved or asked about in its picture"
        place = next(o.place for o in scene.values.spec.observations if o.camera == camera)
        yield Breach(what, place, "turn it with `look_at:`, widen its `fov:`, or leave it out", about=camera)


@rule("WMS603")
def turned_camera(scene: Scene) -> Iterator[Breach]:
    """A camera that has on its left what `relation` does not call so."""
    spec = scene.values.spec
    answers = (part for question in spec.questions for part in parts(question.answer))
    if not any(isinstance(part, Call) and part.function == "relation" and not _from(part) for part in answers):
        return
    way = front(scene.values)
    for observation in spec.observations:
        if facing(scene.values, observation.camera) != way:
            what = f"`{observation.camera}` looks another way than `relation`, which goes by the world's front"
            remedy = f"observe only from one side, or say from which it is meant: `seen_from: {observation.camera}`"
            yield Breach(what, observation.place, remedy, about=observation.camera)


def _from(relation: Call) -> bool:
    """Whether it says for whom it is meant."""
    return any(option.name == "seen_from" for option in relation.options)


@rule("WMS304")
def late_action(scene: Scene) -> Iterator[Breach]:
    """An action that begins when the episode is over."""
    values = scene.values
    end = values.end
    for action in values.spec.things:
        if action.kind == "action" and not (action.of or VERBS[action.verb].holds) and values.there(action.name):
            start = values.number(action.name, "start")
            if start > end - 1e-9:
                lasts = f"the episode lasts {units.told(end, units.TIME)} {scene.where}"
                what = f"`{action.name}` never happens: it begins at {units.told(start, units.TIME)}, and {lasts}"
                remedy = "let it begin earlier, or set a longer `horizon`"
                yield Breach(what, values.place(action.name, "start"), remedy, about=action.name)


@rule("WMS304")
def crowded(scene: Scene) -> Iterator[Breach]:
    """So many things that can touch one another that an instance takes long: every pair is looked at in every step."""
    values = scene.values
    present = [t.name for t in values.spec.things if t.kind == "object" and values.there(t.name)]
    free = [name for name in present if not values.flag(name, "fixed")]
    pairs = len(free) * (len(free) - 1) // 2 + len(free) * (len(present) - len(free))
    seconds = pairs * values.end * _PAIR_SECONDS
    if seconds > _LONG:
        what = f"{len(free)} things can move, and {pairs:,} pairs can touch: an episode may take about {seconds:.0f} s"
        remedy = "have fewer, fix some of them, or observe for less long; `wmspec generate --timeout` gives more time"
        yield Breach(f"{what} {scene.where}", values.place(free[0]), remedy, about="crowded")


@rule("WMS304", "error")
def picture_after_the_end(scene: Scene) -> Iterator[Breach]:
    """An answer that is a picture of what is not executed."""
    for question in scene.values.spec.questions:
        time = pictured(question, scene.values) if asked(question, scene.values) else None
        if time is not None and not scene.values.during(time):
            yield outside(time, scene.values, question.place)


@rule("WMS304", "error")
def measure_outside_the_episode(scene: Scene) -> Iterator[Breach]:
    """A measure at a time that is not executed, or during a span that ends before it begins."""
    values = scene.values
    for question in values.spec.questions:
        if not asked(question, values):
            continue
        for expr, place in _measuring(question):
            for call in (part for part in parts(expr) if isinstance(part, Call)):
                times = dict(_times(call, values))
                if late := [time for time in times.values() if not values.during(time)]:
                    lasts = f"the episode, which lasts {units.told(values.ref('end'), units.TIME)} {scene.where}"
                    what = f"`{call.function}` at {units.told(late[0], units.TIME)} is outside {lasts}"
                    yield Breach(what, place, "ask for an earlier time, or set a longer `horizon`")
                elif times.get("from", 0.0) >= times.get("to", math.inf):
                    what = f"the time of `{call.function}` ends before it begins {scene.where}"
                    yield Breach(what, place, "let `to` be later than `from`")


def _measuring(question: Question) -> Iterator[tuple[Expr, Location]]:
    """The expressions of a question that are measured on the episode."""
    yield question.answer, question.place
    yield from ((ensure.condition, ensure.place) for ensure in question.ensures)
    yield from ((margin.value, margin.place) for margin in question.margins)
    if question.difference is not None:
        yield question.difference.value, question.place


def _times(call: Call, values: Values) -> Iterator[tuple[str, float]]:
    """The times (s) at which a function is measured, by their options, as far as they are known before the episode."""
    for option in call.options:
        if option.name in ("at", "from", "to") and not measured(values.spec, option.value):
            with suppress(NoValue):
                yield option.name, float(evaluate(option.value, values))


RULES = (
    objects_inside_one_another,
    blind_camera,
    turned_camera,
    late_action,
    crowded,
    picture_after_the_end,
    measure_outside_the_episode,
)


def outside(time: float, values: Values, place: Location) -> Breach:
    """A picture at a time (s) when the episode is over."""
    lasts = f"the episode, which lasts {units.told(values.ref('end'), units.TIME)}"
    what = f"a picture at {units.told(time, units.TIME)} is outside {lasts}"
    return Breach(what, place, "ask for an earlier one, or set a longer `horizon`")
