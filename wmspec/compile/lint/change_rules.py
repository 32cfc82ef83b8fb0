"""Rules on counterfactuals: each must change something, and nothing unrelated."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.lint.action_rules import target_beyond_limit
from wmspec.compile.lint.question_rules import answer_picture_time, is_posed
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import LintScene, late_action, objects_inside_one_another, picture_outside
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.episode import build_document
from wmspec.core.diagnostics import Note
from wmspec.lang.check.ir.ir import Counterfactual, Question

#: Properties that legitimately follow from the pose of another entity.
_DERIVED = ("pose", "way", "form", "there", "start")


@dataclass(frozen=True)
class ChangedScene:
    """A counterfactual of a question: the scene, its stage, and the changed scene."""

    question: Question
    change: Counterfactual
    scene: LintScene
    stage: Document
    otherwise: LintScene

    @cached_property
    def differing(self) -> Mapping[str, frozenset[str]]:
        """The differences of the stages with their sources. Raises WmsError if the changed scene cannot be built."""
        return self.stage.differing(self.other_stage)

    @cached_property
    def other_stage(self) -> Document:
        """The changed stage. Raises WmsError if it cannot be built."""
        return build_document(self.otherwise.values, self.otherwise.objects)


@rule("WMS304", "error")
def option_after_the_end(changed: ChangedScene) -> Iterator[Breach]:
    """Find options that are pictures after the end of the episode."""
    truth, otherwise = changed.scene.values, changed.otherwise.values
    time = answer_picture_time(changed.question, truth) if is_posed(changed.question, truth) else None
    if time is not None and truth.during(time) and not otherwise.during(time):
        yield picture_outside(time, otherwise, changed.change.place)


@rule(late_action.code, late_action.severity)
def action_added_too_late(changed: ChangedScene) -> Iterator[Breach]:
    """Find actions that a counterfactual adds after the end of the episode."""
    if changed.change.change == "add":
        yield from (one for one in late_action.breaches(changed.otherwise) if one.about == changed.change.name)


@rule("WMS503", "error")
def idle_counterfactual(changed: ChangedScene) -> Iterator[Breach]:
    """Find counterfactuals that change nothing."""
    name = changed.change.name
    if not changed.differing:
        yield Breach(f"`{name}` changes nothing {changed.scene.where}", changed.change.place, about=name)


@rule("WMS503", "error")
def twin_counterfactuals(changed: ChangedScene) -> Iterator[Breach]:
    """Find pairs of counterfactuals of a question with equal results."""
    values = changed.otherwise.values
    others = changed.question.alternatives(changed.scene.instance.factors)
    before = others[: others.index(changed.change)] if changed.change in others else ()
    for other in before:
        if other.change == "levels" or changed.change.change == "levels":
            continue
        twin = Evaluator(values.spec, changed.scene.instance.values, other, changed.scene.instance.key)
        if _is_equivalent(changed, other, twin):
            what = f"`{changed.change.name}` and `{other.name}` come to the same {changed.scene.where}"
            note = Note(f"`{other.name}` is declared here", other.place)
            yield Breach(what, changed.change.place, "leave one out", (note,), about=changed.change.name)


@rule("WMS505")
def broad_counterfactual(changed: ChangedScene) -> Iterator[Breach]:
    """Find counterfactuals that change more than the named property."""
    change = changed.change
    more = sorted(set(_other_properties(changed)))
    if more:
        target = f"{change.owner}.{change.property}"
        what = f"`{change.name}` changes not only `{target}` but also {' and '.join(f'`{m}`' for m in more)}"
        yield Breach(
            what, change.place, f"say that without `{target}`, in terms of a factor or a `let`", about=change.name
        )


@rule(objects_inside_one_another.code, objects_inside_one_another.severity)
def objects_put_inside_one_another(changed: ChangedScene) -> Iterator[Breach]:
    """Find objects that a counterfactual makes overlap."""
    if changed.change.change == "state":
        yield from objects_inside_one_another.breaches(changed.otherwise)


@rule(target_beyond_limit.code, target_beyond_limit.severity)
def target_put_beyond_limit(changed: ChangedScene) -> Iterator[Breach]:
    """Find drives whose target a counterfactual moves beyond a limit of their joint."""
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


def _is_equivalent(changed: ChangedScene, other: Counterfactual, twin: Evaluator) -> bool:
    """Whether two counterfactuals have equal results; added actions are compared without their names."""
    if changed.change.change == other.change == "add":
        return _effect(changed.otherwise.values, changed.change.name) == _effect(twin, other.name)
    return not changed.other_stage.differing(build_document(twin))


def _effect(values: Evaluator, action: str) -> tuple[str, dict[str, object]]:
    thing = values.spec.thing(action)
    return thing.verb, {name: values.property(action, name) for name in thing.properties}


def _other_properties(changed: ChangedScene) -> Iterator[str]:
    """Yield properties of other entities whose expressions depend on the changed property."""
    change, spec = changed.change, changed.scene.values.spec
    if change.value is None:
        return
    asset = {t.name: t.of for t in spec.things if t.kind == "object"}
    target = f"{change.owner}.{change.property}"
    for sources in changed.differing.values():
        owned = [source.rpartition(".") for source in sources]
        if all(owner != change.owner for owner, _, _ in owned):
            others = (o for o in owned if asset.get(o[0]) != change.owner)  # links of an asset depend on its base
            following = (f"{owner}.{name}" for owner, _, name in others if name not in _DERIVED)
            yield from (source for source in following if target in changed.scene.depend.source(source))
