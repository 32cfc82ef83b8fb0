"""Executes scenes in Newton."""

from __future__ import annotations

from typing import Any

from wmspec.backends.mujoco.impact import constraint_solref
from wmspec.backends.mujoco.info import CONTACT_YIELD, STEPS_PER_SECOND
from wmspec.core.diagnostics import EngineError
from wmspec.core.native_output import silence
from wmspec.sim.scene.capability import require
from wmspec.sim.scene.joints.drives import required_step_rate
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics.episode import Episode, Recording, play
from wmspec.sim.scene.physics.readback import require_equal
from wmspec.sim.scene.physics.rigid import Assembly, assembly
from wmspec.sim.scene.physics.speed import step_multiplier
from wmspec.sim.scene.physics.timeline import episode
from wmspec.sim.scene.regime_thresholds import MAX_STEP_MULTIPLIER
from wmspec.sim.scene.validate import validate

from .contacts import contacts, limit_gains
from .info import INFO
from .world import World

with silence():
    import warp

warp.config.quiet, warp.config.enable_backward = True, False  # kernels without derivatives compile in less time

SINGLE_PRECISION = 1e-6  # Newton uses 32-bit floats


def record(scene: Scene, whole: Assembly, timeline: Episode) -> Recording:
    """Return the recording of an episode. Raises EngineError if the engine fails."""
    with silence():
        world = World(*arguments(whole, timeline))
        verify(world, scene)
        try:
            return play(world, timeline)
        except FloatingPointError as error:
            raise EngineError(f"Newton failed: {error}; look for overlaps or extreme velocities") from error


def prepare(scene: Scene) -> tuple[Assembly, Episode]:
    """Return assembly and timeline of a scene. Raises WmsError with the prim path of unsupported features."""
    validate(scene)
    require(INFO.lacks, scene)
    fast = STEPS_PER_SECOND * step_multiplier(scene, CONTACT_YIELD, MAX_STEP_MULTIPLIER)
    timeline = episode(scene, max(fast, required_step_rate(scene, STEPS_PER_SECOND, damped=False)))
    return assembly(scene, timeline), timeline


def arguments(whole: Assembly, timeline: Episode) -> tuple[Any, ...]:
    """Return the arguments of `World`."""
    return whole, timeline.grips, contacts(whole), limit_gains(whole.step), constraint_solref(whole.step)


def verify(world: World, scene: Scene) -> None:
    """Raise WmsError unless Newton has the masses and friction of the scene."""
    masses, inertias = world.model.body_mass.numpy(), world.model.body_inertia.numpy()
    for number, body in enumerate(scene.bodies):
        if body.motion == "dynamic" and body.inertia is not None:
            link = world.links[number]
            require_equal(body.path, "the mass", masses[link], body.inertia.mass, tolerance=SINGLE_PRECISION)
            require_equal(
                body.path, "the inertia", inertias[link].diagonal(), body.inertia.moments, tolerance=SINGLE_PRECISION
            )
