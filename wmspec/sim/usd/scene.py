"""The scene that a stage describes, gathered from its prims; all that is wrong with them is told at once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import PurePath

from pxr import Usd

from wmspec.core.diagnostics import Report, StageError
from wmspec.sim.scene.joints.drives import weighed
from wmspec.sim.scene.joints.initial_state import settled
from wmspec.sim.scene.joints.loops import opened
from wmspec.sim.scene.joints.momentum import started
from wmspec.sim.scene.model import Action, Body, Camera, Joint, Observation, Scene
from wmspec.sim.scene.physics.scene_warnings import doubts
from wmspec.sim.usd import actions, episode, joints, reach
from wmspec.sim.usd.bodies import bodies
from wmspec.sim.usd.cameras import camera, daylight, overview
from wmspec.sim.usd.filters import filtered
from wmspec.sim.usd.frames import World
from wmspec.sim.usd.ignored_attributes import tell_sideways, tell_unread
from wmspec.sim.usd.prims import Names, targets, value
from wmspec.sim.usd.stage_index import Census, Walk
from wmspec.sim.usd.substitutions import Notes
from wmspec.sim.usd.unsupported import incomplete


def scene(stage: Usd.Stage, notes: Notes) -> Scene:
    """The scene of a stage, as `wmspec.sim.usd.read` says; what is taken for something else goes to `notes`."""
    problems = Report(StageError)
    incomplete(stage, problems)
    census, world = Walk(stage, problems, notes=notes).census, World(stage, problems)
    if not notes.strict and not stage.HasAuthoredMetadata("metersPerUnit"):
        notes.instead(stage.GetPseudoRoot(), "metersPerUnit is not authored", "0.01, as USD has it", "author it")
    everything = bodies(list(census.owners.values()), world, problems, notes)
    known = {body.path: body for body in everything}
    cameras = _cameras(census, known, world, problems, notes)
    chained = joints.joints(census.joints, known, world, problems, notes)
    held, everything = chained.joints, (*everything, *chained.between)
    apart: tuple[tuple[str, str], ...] = ()
    with problems.gathered():
        apart = filtered(stage, census.filters, census.of("PhysicsCollisionGroup"), census.owners, known, held, notes)
    actions_done = _actions(census, everything, held, world, problems)
    observations = _observations(census, cameras, problems)
    with problems.gathered():
        gravity = episode.gravity(census.of("PhysicsScene"), world, notes)
    with problems.gathered():
        task, duration, rate = episode.timing(census.of("WmsEpisode"))
    with problems.gathered():
        light, background = daylight(census.of("DistantLight"), census.of("DomeLight"), world, notes)
    problems.stop_if_failed()
    tell_sideways(stage, notes)
    tell_unread(stage, problems, notes)
    problems.stop_if_failed()
    read = Scene(
        name=task or PurePath(stage.GetRootLayer().GetDisplayName()).stem,
        gravity=gravity,
        bodies=everything,
        actions=actions_done,
        cameras=tuple(cameras.values()) or (overview(everything),),
        light=light,
        background=background,
        observations=observations,
        duration=duration,
        rate=rate,
        joints=tuple(held.values()),
        filtered=apart,
    )
    if notes.strict:
        return read
    read, moved = settled(read)
    doubtful = doubts(read)
    read, begun = started(weighed(opened(read)))
    return replace(read, notes=(*notes.diagnostics, *moved, *begun, *doubtful))


def _cameras(census: Census, known: dict[str, Body], world: World, problems: Report, notes: Notes) -> dict[str, Camera]:
    names, cameras = Names(), {}
    for prim in census.of("Camera"):
        name = names.give(prim.GetName(), str(prim.GetPath()))
        with problems.gathered():
            above = (known.get(str(path)) for path in prim.GetPath().GetAncestorsRange())
            body = next((body for body in above if body is not None and body.motion != "static"), None)
            try:
                cameras[str(prim.GetPath())] = camera(prim, name, body, world)
            except StageError as error:
                notes.rather(error, "left out")
    return cameras


def _actions(
    census: Census, everything: tuple[Body, ...], held: dict[str, Joint], world: World, problems: Report
) -> tuple[Action, ...]:
    known: dict[str, Body] = {body.path: body for body in everything}
    done: list[tuple[Usd.Prim, Action]] = []
    refused = census.owners.keys() - known.keys()
    for prim in census.of("WmsAction"):
        if not refused.isdisjoint(targets(prim, "wms:object")):
            continue  # what is wrong is already said of its object
        with problems.gathered():
            if value(prim, "wms:verb") == "reach":
                done += [(prim, follow) for follow in reach.follows(prim, known, world)]
            else:
                done.append((prim, actions.action(prim, known, held, world)))
    with problems.gathered():
        actions.overlapping(done, everything)
    return tuple(action for _, action in done)


def _observations(census: Census, cameras: dict[str, Camera], problems: Report) -> tuple[Observation, ...]:
    observations = []
    for prim in census.of("WmsObservation"):
        with problems.gathered():
            observations.append(episode.observation(prim, cameras))
    return tuple(observations)
