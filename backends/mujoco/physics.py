"""Executes scenes in MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from wmspec.core.diagnostics import EngineError, WmsError
from wmspec.core.native_output import silence
from wmspec.sim.scene.capability import require
from wmspec.sim.scene.joints.articulations import trees
from wmspec.sim.scene.joints.drives import required_step_rate
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics.contact import colliding_geoms, combine_friction
from wmspec.sim.scene.physics.episode import Episode, Recording, play
from wmspec.sim.scene.physics.readback import require_equal
from wmspec.sim.scene.physics.rigid import Assembly, assembly
from wmspec.sim.scene.physics.speed import step_multiplier
from wmspec.sim.scene.physics.timeline import episode
from wmspec.sim.scene.regime_thresholds import MAX_STEP_MULTIPLIER
from wmspec.sim.scene.validate import validate

from . import rollout
from .impact import solref
from .info import CONTACT_YIELD, INFO, STEPS_PER_SECOND
from .joints import MAX_FINITE
from .mjcf import mjcf
from .world import World

with silence():
    import mujoco


def record(scene: Scene, whole: Assembly, timeline: Episode) -> Recording:
    """Return the recording of an episode. Raises EngineError if the engine fails."""
    with suppress_log():
        text = mjcf(scene, timeline, whole, seen=False)
        return _record_rollout(text, scene, whole, timeline) or _record_steps(text, scene, whole, timeline)


def _record_rollout(text: str, scene: Scene, whole: Assembly, timeline: Episode) -> Recording | None:
    """Return the recording of an episode stepped by `mujoco.rollout`; None if events prevent that or MuJoCo warns."""
    if not rollout.is_uneventful(scene, timeline):
        return None
    try:
        return rollout.play(_world(rollout.with_contact_sensors(text, scene), scene, whole, timeline), scene, timeline)
    except FloatingPointError:  # the step loop reports the step
        return None


def _record_steps(text: str, scene: Scene, whole: Assembly, timeline: Episode) -> Recording:
    try:
        return play(_world(text, scene, whole, timeline), timeline)
    except FloatingPointError as error:
        raise EngineError(f"MuJoCo failed: {error}; look for overlaps or extreme velocities") from error


def _world(text: str, scene: Scene, whole: Assembly, timeline: Episode) -> World:
    """Return a world with verified physics. Raises WmsError if MuJoCo reads the model differently."""
    try:
        world = World(mujoco.MjModel.from_xml_string(text), whole)
    except ValueError as error:
        raise WmsError(f"MuJoCo cannot load the scene: {error}") from error
    verify(world, scene, timeline)
    return world


def prepare(scene: Scene) -> tuple[Assembly, Episode]:
    """Return assembly and timeline of a scene. Raises WmsError with the prim path of unsupported features."""
    validate(scene)
    require(INFO.lacks, scene)
    fast = STEPS_PER_SECOND * step_multiplier(scene, CONTACT_YIELD, MAX_STEP_MULTIPLIER)
    timeline = episode(scene, max(fast, required_step_rate(scene, STEPS_PER_SECOND, damped=False)))
    return assembly(scene, timeline), timeline


def verify(world: World, scene: Scene, timeline: Episode) -> None:
    """Raise WmsError unless MuJoCo has the physics of the scene."""
    model = world.model
    require_equal("MuJoCo", "the time step", model.opt.timestep, timeline.step)
    require_equal("MuJoCo", "gravity", model.opt.gravity, scene.gravity)
    for i, body in zip(world.ids, scene.bodies, strict=True):
        if body.inertia is not None:
            require_equal(body.path, "the mass", model.body_mass[i], body.inertia.mass)
            require_equal(body.path, "the inertia", model.body_inertia[i], body.inertia.moments)
    for limb in (limb for tree in trees(scene) for limb in tree):
        joint = scene.joints[limb.joint]
        if limb.limits:
            require_equal(
                joint.path, "the limits", model.joint(joint.name).range, np.clip(limb.limits, -MAX_FINITE, MAX_FINITE)
            )
        if limb.drive:
            require_equal(joint.path, "the drive", -model.actuator(joint.name).biasprm[1:3], limb.drive[:2])
    for i, (a, g, _, h) in enumerate(colliding_geoms(scene)):
        pair = combine_friction(g.friction, h.friction)
        require_equal(f"{a.path}/{g.name}", "friction", model.pair_friction[i, :2], [pair.dynamic] * 2)
        require_equal(f"{a.path}/{g.name}", "restitution", model.pair_solref[i], solref(pair, timeline.step))


@contextmanager
def suppress_log() -> Iterator[None]:
    """Prevent MuJoCo from writing warnings to a file in the working directory; they are checked here."""
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)
