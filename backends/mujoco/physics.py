"""Run a scene in MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from wmspec.core.diagnostics import EngineError, WmsError
from wmspec.core.native_output import silence
from wmspec.sim.scene.capability import require
from wmspec.sim.scene.joints.articulations import trees
from wmspec.sim.scene.joints.drives import enough
from wmspec.sim.scene.model import Scene, Trace
from wmspec.sim.scene.physics.contact import mix, touchable
from wmspec.sim.scene.physics.episode import Episode, Recording, play, told
from wmspec.sim.scene.physics.readback import readback
from wmspec.sim.scene.physics.rigid import Assembly, assembly
from wmspec.sim.scene.physics.speed import steps
from wmspec.sim.scene.physics.timeline import episode
from wmspec.sim.scene.physics.to_trace import trace
from wmspec.sim.scene.regime_thresholds import FINEST
from wmspec.sim.scene.validate import validate

from . import rollout
from .impact import solref
from .info import GIVES, INFO, STEPS_PER_SECOND
from .joints import FAR
from .mjcf import mjcf
from .world import World

with silence():
    import mujoco


def execute(scene: Scene) -> Trace:
    """The trace of the scene's episode.

    Raises WmsError for a scene that MuJoCo can't honour, EngineError when MuJoCo loses track of it.
    """
    whole, timeline = prepare(scene)
    return trace(INFO.name, scene, timeline, told(timeline) or _played(scene, whole, timeline))


def _played(scene: Scene, whole: Assembly, timeline: Episode) -> Recording:
    with unlogged():
        text = mjcf(scene, timeline, whole, seen=False)
        return _quick(text, scene, whole, timeline) or _slow(text, scene, whole, timeline)


def _quick(text: str, scene: Scene, whole: Assembly, timeline: Episode) -> Recording | None:
    """What is recorded where MuJoCo can be left alone between events; None where it cannot, or warns."""
    if not rollout.uneventful(scene, timeline):
        return None
    try:
        return rollout.play(_world(rollout.sensed(text, scene), scene, whole, timeline), scene, timeline)
    except FloatingPointError:  # the loop tells at which step
        return None


def _slow(text: str, scene: Scene, whole: Assembly, timeline: Episode) -> Recording:
    try:
        return play(_world(text, scene, whole, timeline), timeline)
    except FloatingPointError as error:
        raise EngineError(f"MuJoCo lost the episode: {error}; look for overlaps or extreme velocities") from error


def _world(text: str, scene: Scene, whole: Assembly, timeline: Episode) -> World:
    """A world that has the scene's physics, by its MJCF. Raises WmsError if MuJoCo reads it otherwise."""
    try:
        world = World(mujoco.MjModel.from_xml_string(text), whole)
    except ValueError as error:
        raise WmsError(f"MuJoCo can't load the scene: {error}") from error
    verify(world, scene, timeline)
    return world


def prepare(scene: Scene) -> tuple[Assembly, Episode]:
    """The scene in MuJoCo's words. Raises WmsError, with the prim path, for what MuJoCo doesn't have."""
    validate(scene)
    require(INFO.lacks, scene)
    fast = STEPS_PER_SECOND * steps(scene, GIVES, FINEST)
    timeline = episode(scene, max(fast, enough(scene, STEPS_PER_SECOND, damped=False)))
    return assembly(scene, timeline), timeline


def verify(world: World, scene: Scene, timeline: Episode) -> None:
    """Raise WmsError unless MuJoCo has the scene's physics."""
    model = world.model
    readback("MuJoCo", "the time step", model.opt.timestep, timeline.step)
    readback("MuJoCo", "gravity", model.opt.gravity, scene.gravity)
    for i, body in zip(world.ids, scene.bodies, strict=True):
        if body.inertia is not None:
            readback(body.path, "the mass", model.body_mass[i], body.inertia.mass)
            readback(body.path, "the inertia", model.body_inertia[i], body.inertia.moments)
    for limb in (limb for tree in trees(scene) for limb in tree):
        joint = scene.joints[limb.joint]
        if limb.limits:
            readback(joint.path, "the limits", model.joint(joint.name).range, np.clip(limb.limits, -FAR, FAR))
        if limb.drive:
            readback(joint.path, "the drive", -model.actuator(joint.name).biasprm[1:3], limb.drive[:2])
    for i, (a, g, _, h) in enumerate(touchable(scene)):
        pair = mix(g.friction, h.friction)
        readback(f"{a.path}/{g.name}", "friction", model.pair_friction[i, :2], [pair.dynamic] * 2)
        readback(f"{a.path}/{g.name}", "restitution", model.pair_solref[i], solref(pair, timeline.step))


@contextmanager
def unlogged() -> Iterator[None]:
    """MuJoCo's warnings are checked here; it must not also write them to a file in the working directory."""
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)
