"""Native scripts: the text of a program that executes an episode with an engine and numpy alone."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from pprint import pformat
from typing import Any

from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.model.transform import (
    conjugate,
    cross,
    from_rotation_vector,
    multiply,
    rotate,
    rotate_one,
    to_rotation_vector,
)
from wmspec.sim.scene.physics.episode import (
    BREAK_LENGTH,
    TOUCH_BEGIN,
    TOUCH_END,
    Aim,
    Drag,
    Episode,
    Grip,
    Hold,
    Jump,
    Kick,
    KinematicPath,
    Passage,
    Push,
    Recording,
    apply_events,
    apply_forces,
    apply_grips,
    broken_grips,
    event_steps,
    kinematic_recording,
    path_steps,
    perform,
    play,
    play_together,
    quiet_steps,
    record_state,
    scripted_states,
    to_body_frames,
)

_COMMON: tuple[Callable[..., Any], ...] = (
    conjugate,
    multiply,
    cross,
    rotate_one,
    rotate,
    from_rotation_vector,
    to_rotation_vector,
    Kick,
    Push,
    Drag,
    Hold,
    Jump,
    Aim,
    Grip,
    Passage,
    KinematicPath,
    Episode,
    Recording,
    play,
    play_together,
    perform,
    path_steps,
    kinematic_recording,
    scripted_states,
    apply_events,
    event_steps,
    quiet_steps,
    apply_forces,
    record_state,
    apply_grips,
    broken_grips,
    to_body_frames,
)
_HEAD = '''"""Plays the episode "{name}" in {engine} and writes its trace to trace.npz, next to this file.

In trace.npz: time (T,) s; bodies (N,); position (T, N, 3) m and orientation (T, N, 4), quaternion (w, x, y, z), of the
bodies' frames; linear_velocity and angular_velocity (T, N, 3) of their centres of mass, in world axes, m/s and rad/s.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import exp, inf, pi, sqrt
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import {module}
'''
_MAIN = """if __name__ == "__main__":
{world}
    states = play(world, EPISODE).states
    time = np.arange(EPISODE.samples) / EPISODE.rate
    np.savez(
        Path(__file__).with_name("trace.npz"),
        time=time,
        bodies=NAMES,
        position=states[..., :3],
        orientation=states[..., 3:7],
        linear_velocity=states[..., 7:10],
        angular_velocity=states[..., 10:],
    )
    for name, position in zip(NAMES, states[-1, :, :3]):
        print(f"{{name}}: at {{time[-1]:.3f}} s at {{np.round(position, 4)}} m")
"""


def episode_script(
    engine: str,
    module: str,
    scene: Scene,
    *,
    parts: Sequence[Callable[..., Any]],
    values: Mapping[str, object],
    world: str,
) -> str:
    """Return the text of a script.

    `parts` are functions and classes to copy, `values` are literals by name whose `repr` is valid Python (with
    `EPISODE`), and `world` are the lines that create the world.
    """
    values = {
        "NAMES": [body.name for body in scene.bodies],
        "TOUCH_BEGIN": TOUCH_BEGIN,
        "TOUCH_END": TOUCH_END,
        "BREAK_LENGTH": BREAK_LENGTH,
        **values,
    }
    sections = [
        _HEAD.format(name=scene.name, engine=engine, module=module),
        *(inspect.getsource(part) for part in (*_COMMON, *parts)),
        "\n".join(f"{name} = {pformat(value, width=110, sort_dicts=False)}" for name, value in values.items()) + "\n",
        _MAIN.format(world="\n".join(f"    {line}" for line in world.splitlines())),
    ]
    return "\n\n".join(sections)
