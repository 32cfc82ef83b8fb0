"""Rules on what a counterfactual changes in the scene of an instance: something, and no more than it says."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from wmspec.compile.layout.values import Values
from wmspec.compile.lint.action_rules import target_beyond_limit
from wmspec.compile.lint.question_rules import asked, pictured
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import Scene, late_action, objects_inside_one_another, outside
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.episode import built
from wmspec.core.diagnostics import Note
from wmspec.lang.check.ir.ir import Counterfactual, Question

#: What follows from the place or the turn of something else, as it should.
_FOLLOWS = ("pose", "way", "form", "there", "start")


@dataclass(frozen=True)
class Changed:
    """A counterfactual of a question: the scene, its stage, and the scene as it would be."""

    question: Question
    change: Counterfactual
    scene: Scene
    stage: Document
    otherwise: Scene

    @cached_property
    def differing(self) -> Mapping[str, frozenset[str]]:
        """What differs on the stages, with what it was made of. Raises WmsError if the other cannot be built."""
        return self.stage.differing(self.other_stage)

    @cached_property
    def other_stage(self) -> Document:
        """The stage as it would be. Raises WmsError if it cannot be built."""
        return built(self.otherwise.values)


@rule("WMS304", "error")
def option_after_the_end(changed: Changed) -> Iterator[Breach]:
    """An option that is a picture of what is not executed, where the answer is."""
    truth, otherwise = changed.scene.values, changed.otherwise.values
    time = pictured(changed.question, truth) if asked(changed.question, truth) else None
    if time is not None and truth.during(time) and not otherwise.during(time):
        yield outside(time, otherwise, changed.change.place)


@rule(late_action.code, late_action.severity)
def action_added_too_late(changed: Changed) -> Iterator[Breach]:
    """An action that a counterfactual adds when the episode is over."""
    if changed.change.change == "add":
        yield from (one for one in late_action.breaches(changed.otherwise) if one.about == changed.change.name)


@rule("WMS503", "error")
def idle_counterfactual(changed: Changed) -> Iterator[Breach]:
    """A counterfactual that changes nothing."""
    name = changed.change.name
    if not changed.differing:
        yield Breach(f"`{name}` changes nothing {changed.scene.where}", changed.change.place, about=name)


@rule("WMS503", "error")
def twin_counterfactuals(changed: Changed) -> Iterator[Breach]:
    """Two counterfactuals of a question after which all is the same."""
    values = changed.otherwise.values
    others = changed.question.alternatives(changed.scene.instance.factors)
    before = others[: others.index(changed.change)] if changed.change in others else ()
    for other in before:
        if other.change == "levels" or changed.change.change == "levels":
            continue
        twin = Values(values.spec, changed.scene.instance.values, other, changed.scene.instance.key)
        if _alike(changed, other, twin):
            what = f"`{changed.change.name}` and `{other.name}` come to the same {changed.scene.where}"
            note = Note(f"`{other.name}` is declared here", other.place)
            yield Breach(what, changed.change.place, "leave one out", (note,), about=changed.change.name)


@rule("WMS505")
def broad_counterfactual(changed: Changed) -> Iterator[Breach]:
    """A counterfactual that changes more than it says."""
    change = changed.change
    more = sorted(set(_more(changed)))
    if more:
        target = f"{change.owner}.{change.property}"
        what = f"`{change.name}` changes not only `{target}` but also {' and '.join(f'`{m}`' for m in more)}"
        yield Breach(
            what, change.place, f"say that without `{target}`, in terms of a factor or a `let`", about=change.name
        )


@rule(objects_inside_one_another.code, objects_inside_one_another.severity)
def objects_put_inside_one_another(changed: Changed) -> Iterator[Breach]:
    """Objects that a changed state puts inside one another."""
    if changed.change.change == "state":
        yield from objects_inside_one_another.breaches(changed.otherwise)


@rule(target_beyond_limit.code, target_beyond_limit.severity)
def target_put_beyond_limit(changed: Changed) -> Iterator[Breach]:
    """A drive that a counterfactual sends beyond a limit of its joint."""
    if changed.change.property == "target":
        before = {one.about for one in target_beyond_limit.breaches(changed.scene)}
        for one in (one for one in target_beyond_limit.breaches(changed.otherwise) if one.about not in before):
            yield replace(one, place=changed.change.place, about=(changed.change.place, one.about))


RULES = (
    option_after_the_end,
    action_added_too_late,
    idle_counterfactual,
    twin_counterfactuals,
    broad_counterfactual,
    objects_put_inside_one_another,
    target_put_beyond_limit,
)


def _alike(changed: Changed, other: Counterfactual, twin: Values) -> bool:
    """Whether two counterfactuals come to the same; added actions differ on the stages in their names at least."""
    if changed.change.change == other.change == "add":
        return _done(changed.otherwise.values, changed.change.name) == _done(twin, other.name)
    return not changed.other_stage.differing(built(twin))


def _done(values: Values, action: str) -> tuple[str, dict[str, object]]:
    thing = values.spec.thing(action)
    return thing.verb, {name: values.property(action, name) for name in thing.properties}


def _more(changed: Changed) -> Iterator[str]:
    """Properties of other things that are said in terms of what is changed."""
    change, spec = changed.change, changed.scene.values.spec
    if change.value is None:
        return
    asset = {t.name: t.of for t in spec.things if t.kind == "object"}
    target = f"{change.owner}.{change.property}"
    for sources in changed.differing.values():
        owned = [source.rpartition(".") for source in sources]
        if all(owner != change.owner for owner, _, _ in owned):
            others = (o for o in owned if asset.get(o[0]) != change.owner)  # the whole is said of each link
            following = (f"{owner}.{name}" for owner, _, name in others if name not in _FOLLOWS)
            yield from (source for source in following if target in changed.scene.depend.source(source))
