"""Rules on questions whose answer is given away by the text or the pictures."""

from __future__ import annotations

from collections.abc import Iterator

from wmspec.compile.lint.question_rules import answer_picture_time, is_posed
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import LintScene
from wmspec.compile.lint.task_rules import LintTask
from wmspec.lang.check.ir.evaluate import evaluate, subexpressions
from wmspec.lang.check.ir.ir import Expr, Interpolation, Property, Question, Ref, TaskSpec, Value, time_of_last_picture
from wmspec.lang.check.statements.films import answer_camera
from wmspec.lang.check.types import units

#: Properties that are visible in every picture.
_VISIBLE_PROPERTIES = ("form", "color", "material", "image", "scale")
#: Longest chain of names that is followed.
_MAX_NAMES = 20
#: Times closer than this (s) are equal.
_MOMENT = 1e-9


@rule("WMS510")
def answer_in_text(task: LintTask) -> Iterator[Breach]:
    """Find texts that contain everything that distinguishes the options, or the answer itself."""
    for question in task.spec.questions:
        mentioned = [part.value for part in question.text if isinstance(part, Interpolation)]
        decisive = {varied.factor for varied in question.orbit}
        if decisive and decisive <= {value.name for value in mentioned if isinstance(value, Ref)}:
            names = " and ".join(f"`{name}`" for name in sorted(decisive))
            what = f"the text says {names}, which is all that decides between the options"
            yield Breach(what, question.place, "leave one of them to the pictures", about=("text", question.place))
        elif _meaning(question.answer, task.spec) in [_meaning(value, task.spec) for value in mentioned]:
            what = "the text says the answer"
            yield Breach(what, question.place, "leave it to the pictures", about=("text", question.place))


def _meaning(expr: Expr, spec: TaskSpec) -> Expr:
    """Return what a named value or a property of an object stands for: `ball.color` and `tone` may be the same."""
    lets = {let.name: let.value for let in spec.lets}
    things = {thing.name: thing for thing in spec.things}
    for _ in range(_MAX_NAMES):
        match expr:
            case Ref(name=name) if name in lets:
                expr = lets[name]
            case Property(owner=Value(value=str(owner)), name=name) if name in things[owner].properties:
                expr = things[owner].properties[name].value
            case _:
                break
    return expr


@rule("WMS510")
def answer_in_appearance(task: LintTask) -> Iterator[Breach]:
    """Find states of a closed set that are visible in all pictures and so eliminate options."""
    painted = set(_painted(task))
    for question in task.spec.questions:
        for varied in question.orbit:
            if varied.reads == "action":
                continue
            for thing in (t for t in task.spec.things if t.kind in ("object", "part")):
                looks = [p for p in _VISIBLE_PROPERTIES if p != "color" or thing.name.split(".")[0] not in painted]
                if any(varied.factor in task.depend.source(f"{thing.name}.{look}") for look in looks):
                    what = f"`{varied.factor}` decides what `{thing.name}` looks like, in the options and before"
                    remedy = "let it change what cannot be seen at the end, such as a mass, or a place that is left"
                    yield Breach(what, question.place, remedy, about=("looks", question.place, varied.factor))
                    break


@rule("WMS510")
def answer_in_one_picture(task: LintTask) -> Iterator[Breach]:
    """Find possible and impossible episodes whose pictures are not balanced in groups."""
    for question in task.spec.questions:
        if question.asks_possible and not (task.spec.plan.kind == "groups" and task.spec.plan.cross):
            what = "a single picture may tell whether the episode is possible"
            remedy = "cross what is before and what is after in groups: `design groups of N { cross: [before, later] }`"
            yield Breach(what, question.place, remedy, about=("possible", question.place))


@rule("WMS510")
def answer_in_pictures(scene: LintScene) -> Iterator[Breach]:
    """Find pictures that show the answer; in a prediction, any picture at or after the answer's time."""
    values = scene.values
    shown = [(o, moment) for o in values.spec.observations for moment in evaluate(o.times, values)]
    for question in values.spec.questions:
        time = answer_picture_time(question, values) if is_posed(question, values) else None
        if time is None:
            continue
        # Without earlier pictures the question requests the view of another camera, not a prediction.
        is_prediction = bool(question.orbit) and any(moment < time - _MOMENT for _, moment in shown)
        for observation, moment in shown:
            itself = abs(moment - time) < _MOMENT and observation.camera == answer_camera(question)
            if itself or (is_prediction and moment > time - _MOMENT):
                at = units.format_quantity(moment, units.TIME)
                what = f"the requested picture is shown: that at {at}, {scene.where}"
                yield Breach(what, observation.place, _remedy(scene, question), about=("shown", question.place))
                break


def _painted(task: LintTask) -> Iterator[str]:
    """Yield the objects that an action may paint: the options do not show the colours that they had before."""
    for action in task.spec.things:
        if action.kind == "action" and action.verb == "paint":
            for part in subexpressions(action.properties["object"].value):
                if part.kind == "value":
                    yield str(part.value)


TASK_RULES = (answer_in_text, answer_in_appearance, answer_in_one_picture)
SCENE_RULES = (answer_in_pictures,)


def _remedy(scene: LintScene, question: Question) -> str:
    """Return the remedy; without a `horizon` the end is the last picture that is shown."""
    spec = scene.values.spec
    unwritten = spec.horizon == time_of_last_picture(spec.observations)
    if unwritten and any(isinstance(part, Ref) and part.name == "end" for part in subexpressions(question.answer)):
        return "without a `horizon` the last picture is the end: write `horizon TIME`, a later one"
    return "show what comes before it"
