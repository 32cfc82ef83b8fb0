"""Rules on questions that can be answered without what they are about."""

from __future__ import annotations

from collections.abc import Iterator

from wmspec.compile.lint.question_rules import asked, pictured
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import Scene
from wmspec.compile.lint.task_rules import Task
from wmspec.lang.check.ir.evaluate import evaluate, parts
from wmspec.lang.check.ir.ir import Question, Ref, Said, last_shown
from wmspec.lang.check.types import units

#: What pictures show of a thing whatever happens to it.
_LOOKS = ("form", "color", "material", "image", "scale")
#: Times closer than this (s) are one.
_MOMENT = 1e-9


@rule("WMS510")
def told_by_text(task: Task) -> Iterator[Breach]:
    """A text that says all that decides between the options, or the answer itself."""
    for question in task.spec.questions:
        mentioned = [part.value for part in question.text if isinstance(part, Said)]
        decisive = {varied.factor for varied in question.orbit}
        if decisive and decisive <= {value.name for value in mentioned if isinstance(value, Ref)}:
            names = " and ".join(f"`{name}`" for name in sorted(decisive))
            what = f"the text says {names}, which is all that decides between the options"
            yield Breach(what, question.place, "leave one of them to the pictures", about=("text", question.place))
        elif question.answer in mentioned:
            what = "the text says the answer"
            yield Breach(what, question.place, "leave it to the pictures", about=("text", question.place))


@rule("WMS510")
def told_by_looks(task: Task) -> Iterator[Breach]:
    """A state of a closed set that all pictures show: two of the options can be left aside at once."""
    for question in task.spec.questions:
        for varied in question.orbit:
            if varied.reads == "action":
                continue
            for thing in (t for t in task.spec.things if t.kind in ("object", "part")):
                if any(varied.factor in task.depend.source(f"{thing.name}.{look}") for look in _LOOKS):
                    what = f"`{varied.factor}` decides what `{thing.name}` looks like, in the options and before"
                    remedy = "let it change what cannot be seen at the end, such as a mass, or a place that is left"
                    yield Breach(what, question.place, remedy, about=("looks", question.place, varied.factor))
                    break


@rule("WMS510")
def told_by_pictures(scene: Scene) -> Iterator[Breach]:
    """A picture that is asked for and shown; of a closed set that is foretold, any that is no earlier."""
    values = scene.values
    shown = [(o, moment) for o in values.spec.observations for moment in evaluate(o.times, values)]
    for question in values.spec.questions:
        time = pictured(question, values) if asked(question, values) else None
        if time is None:
            continue
        # Where nothing earlier is shown, nothing is foretold: another camera then asks for the view from elsewhere.
        foretold = bool(question.orbit) and any(moment < time - _MOMENT for _, moment in shown)
        for observation, moment in shown:
            itself = abs(moment - time) < _MOMENT and observation.camera == _camera(question)
            if itself or (foretold and moment > time - _MOMENT):
                at = units.told(moment, units.TIME)
                what = f"the picture that is asked for is shown: that at {at}, {scene.where}"
                yield Breach(what, observation.place, _remedy(scene, question), about=("shown", question.place))
                break


TASK_RULES = (told_by_text, told_by_looks)
SCENE_RULES = (told_by_pictures,)


def _remedy(scene: Scene, question: Question) -> str:
    """Without a `horizon`, the end is the last picture that is shown."""
    spec = scene.values.spec
    unwritten = spec.horizon == last_shown(spec.observations)
    if unwritten and any(isinstance(part, Ref) and part.name == "end" for part in parts(question.answer)):
        return "without a `horizon` the last picture is the end: write `horizon TIME`, a later one"
    return "show what comes before it"


def _camera(question: Question) -> str:
    """The camera of the picture that is asked for, if it is always the same."""
    answer = question.answer
    first = answer.arguments[0] if answer.kind == "call" and answer.arguments else None
    return str(first.value) if first is not None and first.kind == "value" else ""
