"""Turns a recording into a `Trace`."""

from __future__ import annotations

import numpy as np

from wmspec.core.diagnostics import EngineError
from wmspec.sim.scene.model import Scene, Trace
from wmspec.sim.scene.physics.contact import intervals
from wmspec.sim.scene.physics.episode import Episode, Recording
from wmspec.sim.scene.physics.grasp_checks import missed_grasp, penetration

GRASP_REMEDY = "shorten or reroute the path of the arm, or move the obstacle"
DIVERGED = 1e6  # m, m/s or rad/s: larger or non-finite states count as diverged


def trace(engine: str, scene: Scene, episode: Episode, recording: Recording) -> Trace:
    """Return the trace of an episode.

    Raises EngineError with body and time if the engine diverged, a grasp failed, or an arm squeezed two bodies.
    """
    states = recording.states
    lost = ~(np.abs(states).max(axis=-1) < DIVERGED)
    if lost.any():
        sample, body = np.argwhere(lost)[0]
        raise EngineError(
            f"{engine} lost {scene.bodies[body].path} at {sample / scene.rate:.3f} s, at {states[sample, body, :3]} m; "
            "look for bodies that overlap at the start, extreme masses or extreme velocities"
        )
    names = tuple(body.name for body in scene.bodies)
    made = Trace(
        engine=engine,
        bodies=names,
        time=np.arange(episode.samples) / scene.rate,
        position=states[..., :3],
        orientation=states[..., 3:7],
        linear_velocity=states[..., 7:10],
        angular_velocity=states[..., 10:],
        contacts=intervals(recording.touching, names, episode.step, gap=1 / scene.rate),
    )
    if miss := missed_grasp(scene, made):
        time, hand, held = miss
        raise EngineError(
            f"{held} is not between the fingers of {hand} when the grip begins at {time:.3f} s in {engine}",
            help="another body moved it: keep it clear until then",
        )
    for time, number, length in recording.broken_grips:
        grip = episode.grips[number]
        raise EngineError(
            f"{scene.bodies[grip.hand].path} drops {scene.bodies[grip.body].path} at {time:.3f} s: in {engine} "
            f"they part by {1e3 * length:.1f} mm",
            help=GRASP_REMEDY,
        )
    if press := penetration(scene, made):
        time, one, other, depth = press
        raise EngineError(
            f"an arm presses {one} and {other} {1e3 * depth:.1f} mm into each other at {time:.3f} s in {engine}",
            help=GRASP_REMEDY,
        )
    return made
