"""Rules on actions and drives that cannot take effect: absent objects, targets beyond limits."""

from __future__ import annotations

from collections.abc import Iterator

from wmspec.compile.layout.assets import exceeded_limit, format_coordinate
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import LintScene
from wmspec.core.places import Location


@rule("WMS304")
def target_beyond_limit(scene: LintScene) -> Iterator[Breach]:
    """Find drives with a target beyond a limit of their joint."""
    values = scene.values
    for thing in values.spec.things:
        if thing.kind == "joint" and values.is_present(thing.name) and values.has(thing.name, "target"):
            yield from _beyond(scene, thing.name, thing.name, values.source_location(thing.name, "target"))
        elif thing.kind == "action" and thing.verb == "drive" and not thing.of and values.is_present(thing.name):
            joint = values.reference(thing.name, "joint")
            yield from _beyond(scene, thing.name, joint, values.source_location(thing.name, "target"))


def _beyond(scene: LintScene, owner: str, joint: str, place: Location) -> Iterator[Breach]:
    values = scene.values
    target = values.number(owner, "target")
    if (limit := exceeded_limit(values, joint, target)) is not None:
        end, model = limit, values.spec.thing(joint).model
        most = format_coordinate(values.number(joint, end), model)
        at = format_coordinate(target, model)
        what = f"the target of `{owner}` is {at}, beyond the limit of `{joint}`, {most}, {scene.where}"
        yield Breach(what, place, f"stay within the limits, or set another `{end}:`", about=(owner, "target"))


@rule("WMS304")
def acts_on_nothing(scene: LintScene) -> Iterator[Breach]:
    """Find actions on objects that are absent or have vanished."""
    values = scene.values
    for action in values.spec.things:
        if action.kind != "action" or "object" not in action.properties or action.added:
            continue
        if "when" in action.properties and not values.flag(action.name, "when"):
            continue
        name = values.reference(action.name, "object")
        place = values.source_location(action.name, "object")
        if not values.is_present(name):
            remedy = "exclude this with `require`, or name one that is there"
            if values.spec.thing(name).set:
                remedy = "count from the end, as `[-1]` is the last that is there; or exclude this with `require`"
            what = f"`{action.name}` does nothing: `{name}` is not there {scene.where}"
            yield Breach(what, place, remedy, about=action.name)
        elif values.is_present(action.name):
            starts = values.number(action.name, "start")
            for gone in values.actions_on("vanish", name):
                if gone is not action and values.number(gone.name, "start") < starts:
                    what = f"`{action.name}` does nothing: `{name}` vanished before, with `{gone.name}`"
                    yield Breach(what, place, "let it begin earlier, or leave it out", about=action.name)


RULES = (target_beyond_limit, acts_on_nothing)
