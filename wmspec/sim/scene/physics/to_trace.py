"""From what an engine recorded to a `Trace`."""

from __future__ import annotations

import numpy as np

from wmspec.core.diagnostics import EngineError
from wmspec.sim.scene.model import Scene, Trace
from wmspec.sim.scene.physics.contact import intervals
from wmspec.sim.scene.physics.episode import Episode, Recording
from wmspec.sim.scene.physics.grasp_checks import missed, pressed

AROUND = "let the arm go less far or another way, or move what is in its way by then"
LOST = 1e6  # m, m/s or rad/s: beyond this, or not finite, an engine has diverged


def trace(engine: str, scene: Scene, episode: Episode, recording: Recording) -> Trace:
    """The trace of an episode. Raises EngineError, with what and when, if an engine diverged or what is held stuck."""
    states = recording.states
    lost = ~(np.abs(states).max(axis=-1) < LOST)
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
    if miss := missed(scene, made):
        time, hand, held = miss
        raise EngineError(
            f"{held} is not between the fingers of {hand} that are to hold it at {time:.3f} s in {engine}",
            help="something moved it before: let nothing touch it until then",
        )
    for time, number, length in recording.torn:
        grip = episode.grips[number]
        raise EngineError(
            f"{scene.bodies[grip.hand].path} loses hold of {scene.bodies[grip.body].path} at {time:.3f} s: in {engine} "
            f"they part by {1e3 * length:.1f} mm",
            help=AROUND,
        )
    if press := pressed(scene, made):
        time, one, other, depth = press
        raise EngineError(
            f"an arm presses {one} and {other} {1e3 * depth:.1f} mm into one another at {time:.3f} s in {engine}",
            help=AROUND,
        )
    return made
