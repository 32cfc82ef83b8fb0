"""Assembles the scene of a stage and collects all errors."""

from __future__ import annotations

from dataclasses import replace
from pathlib import PurePath

from pxr import Usd

from wmspec.core.diagnostics import Report, StageError
from wmspec.core.limits import CAMERAS
from wmspec.sim.scene.joints.drives import with_force_drives
from wmspec.sim.scene.joints.initial_state import project_to_limits
from wmspec.sim.scene.joints.loops import split_loops
from wmspec.sim.scene.joints.momentum import project_velocities
from wmspec.sim.scene.model import Action, Body, Camera, Joint, Observation, Scene
from wmspec.sim.scene.physics.scene_warnings import scene_warnings
from wmspec.sim.usd import actions, actuators, episode, joint_paths, joints
from wmspec.sim.usd.bodies import bodies
from wmspec.sim.usd.cameras import camera, daylight, overview
from wmspec.sim.usd.filters import filtered_pairs
from wmspec.sim.usd.frames import StageFrame
from wmspec.sim.usd.ignored_attributes import warn_ignored_attributes, warn_up_axis
from wmspec.sim.usd.layer_metrics import warn_layer_metrics, warn_missing_unit
from wmspec.sim.usd.prims import Names, targets, value
from wmspec.sim.usd.stage_index import StageIndex, StageWalk
from wmspec.sim.usd.substitutions import Substitutions
from wmspec.sim.usd.unsupported import report_missing_files


def scene(stage: Usd.Stage, notes: Substitutions) -> Scene:
    """Return the scene of a stage (see `wmspec.sim.usd.read`); substitutions go to `notes`."""
    problems = Report(StageError)
    report_missing_files(stage, problems)
    census, world = StageWalk(stage, problems, notes=notes).census, StageFrame(stage, problems)
    if not notes.strict:
        warn_missing_unit(stage, notes)
    everything = bodies(list(census.owners.values()), world, problems, notes)
    known = {body.path: body for body in everything}
    cameras = _cameras(census, known, world, problems, notes)
    chained = joints.joints(census.joints, known, world, problems, notes)
    acting = [prim for kind in actuators.TYPES for prim in census.of(kind)]
    held = actuators.with_actuators(acting, chained.joints, problems, notes)
    everything = (*everything, *chained.between)
    apart: tuple[tuple[str, str], ...] = ()
    with problems.collect_errors():
        apart = filtered_pairs(
            stage, census.filters, census.of("PhysicsCollisionGroup"), census.owners, known, held, notes
        )
    actions_done = _actions(census, everything, held, world, problems)
    observations = _observations(census, cameras, problems)
    with problems.collect_errors():
        gravity = episode.gravity(census.of("PhysicsScene"), world, notes)
    with problems.collect_errors():
        task, duration, rate = episode.timing(census.of("WmsEpisode"))
    with problems.collect_errors():
        light, background = daylight(census.of("DistantLight"), census.of("DomeLight"), world, notes)
    problems.stop_if_failed()
    warn_up_axis(stage, notes)
    with problems.collect_errors():
        warn_layer_metrics(stage, notes)
    warn_ignored_attributes(stage, problems, notes)
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
    read, moved = project_to_limits(read)
    warnings = scene_warnings(read)
    read, begun = project_velocities(with_force_drives(split_loops(read)))
    return replace(read, notes=(*notes.diagnostics, *moved, *begun, *warnings))


def _cameras(
    census: StageIndex, known: dict[str, Body], world: StageFrame, problems: Report, notes: Substitutions
) -> dict[str, Camera]:
    if len(census.of("Camera")) > CAMERAS.most:
        raise CAMERAS.exceeded()
    names, cameras = Names(), {}
    for prim in census.of("Camera"):
        name = names.give(prim.GetName(), str(prim.GetPath()))
        with problems.collect_errors():
            above = (known.get(str(path)) for path in prim.GetPath().GetAncestorsRange())
            body = next((body for body in above if body is not None and body.motion != "static"), None)
            try:
                cameras[str(prim.GetPath())] = camera(prim, name, body, world)
            except StageError as error:
                notes.record_error(error, "left out")
    return cameras


def _actions(
    census: StageIndex, everything: tuple[Body, ...], held: dict[str, Joint], world: StageFrame, problems: Report
) -> tuple[Action, ...]:
    known: dict[str, Body] = {body.path: body for body in everything}
    done: list[tuple[Usd.Prim, Action]] = []
    refused = census.owners.keys() - known.keys()
    for prim in census.of("WmsAction"):
        if not refused.isdisjoint(targets(prim, "wms:object")):
            continue  # its object has an error already
        with problems.collect_errors():
            if value(prim, "wms:verb") == "reach":
                done += [(prim, follow) for follow in joint_paths.joint_paths(prim, known, world)]
            else:
                done.append((prim, actions.action(prim, known, held, world)))
    with problems.collect_errors():
        actions.overlapping(done, everything)
    return tuple(action for _, action in done)


def _observations(census: StageIndex, cameras: dict[str, Camera], problems: Report) -> tuple[Observation, ...]:
    observations = []
    for prim in census.of("WmsObservation"):
        with problems.collect_errors():
            observations.append(episode.observation(prim, cameras))
    return tuple(observations)
