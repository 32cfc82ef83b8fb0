"""Rules on what actions and drives are to do in an instance, and cannot: their object is gone, their target beyond."""

from __future__ import annotations

from collections.abc import Iterator

from wmspec.compile.layout.assets import beyond, told
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import Scene
from wmspec.core.places import Location


@rule("WMS304")
def target_beyond_limit(scene: Scene) -> Iterator[Breach]:
    """A drive that is sent beyond a limit of its joint: it presses against that for good."""
    values = scene.values
    for thing in values.spec.things:
        if thing.kind == "joint" and values.there(thing.name) and values.has(thing.name, "target"):
            yield from _beyond(scene, thing.name, thing.name, values.place(thing.name, "target"))
        elif thing.kind == "action" and thing.verb == "drive" and not thing.of and values.there(thing.name):
            joint = values.reference(thing.name, "joint")
            yield from _beyond(scene, thing.name, joint, values.place(thing.name, "target"))


def _beyond(scene: Scene, owner: str, joint: str, place: Location) -> Iterator[Breach]:
    values = scene.values
    target = values.number(owner, "target")
    if (limit := beyond(values, joint, target)) is not None:
        end, model = limit, values.spec.thing(joint).model
        most = told(values.number(joint, end), model)
        what = f"the target of `{owner}` is {told(target, model)}, beyond the limit of `{joint}`, {most}, {scene.where}"
        yield Breach(what, place, f"stay within the limits, or set another `{end}:`", about=(owner, "target"))


@rule("WMS304")
def acts_on_nothing(scene: Scene) -> Iterator[Breach]:
    """An action on what is not there, or no longer."""
    values = scene.values
    for action in values.spec.things:
        if action.kind != "action" or "object" not in action.properties or action.added:
            continue
        name = values.reference(action.name, "object")
        place = values.place(action.name, "object")
        if not values.there(name):
            remedy = "exclude this with `require`, or name one that is there"
            if values.spec.thing(name).set:
                remedy = "count from the end, as `[-1]` is the last that is there; or exclude this with `require`"
            what = f"`{action.name}` does nothing: `{name}` is not there {scene.where}"
            yield Breach(what, place, remedy, about=action.name)
        elif values.there(action.name):
            starts = values.number(action.name, "start")
            for gone in values.acting("vanish", name):
                if gone is not action and values.number(gone.name, "start") < starts:
                    what = f"`{action.name}` does nothing: `{name}` vanished before, with `{gone.name}`"
                    yield Breach(what, place, "let it begin earlier, or leave it out", about=action.name)


RULES = (target_beyond_limit, acts_on_nothing)
