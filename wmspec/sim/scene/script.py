"""Native scripts: the text of a program that executes an episode with an engine and numpy alone."""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from pprint import pformat
from types import ModuleType
from typing import Any, Protocol

from wmspec.sim.scene.joints.articulations import Link, LoopClosure, MimicConstraint
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.model import transform as t
from wmspec.sim.scene.physics import episode
from wmspec.sim.scene.physics.rigid import Assembly, CollisionShape, Rigid

_TURNS = (t.conjugate, t.multiply, t.cross, t.rotate_one, t.rotate, t.from_rotation_vector, t.to_rotation_vector)
_RECORDS = (CollisionShape, Rigid, Link, LoopClosure, MimicConstraint, Assembly)
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
    parts: Sequence[ModuleType | Callable[..., Any]],
    values: Mapping[str, object],
    world: str,
) -> str:
    """Return the text of a script.

    `parts` are functions and classes to copy, or modules with nothing else; the constants that they name come along.
    `values` are literals by name whose `repr` is valid Python (with `EPISODE`), and `world` are the lines that create
    the world.
    """
    copied = [each for part in (*_TURNS, episode, *_RECORDS, *parts) for each in _definitions(part)]
    texts = [inspect.getsource(each) for each in copied]
    values = {"NAMES": [body.name for body in scene.bodies], **_constants(copied, texts), **values}
    sections = [
        _HEAD.format(name=scene.name, engine=engine, module=module),
        *texts,
        "\n".join(f"{name} = {pformat(value, width=110, sort_dicts=False)}" for name, value in values.items()) + "\n",
        _MAIN.format(world="\n".join(f"    {line}" for line in world.splitlines())),
    ]
    return "\n\n".join(sections)


def _definitions(part: Any) -> list[Any]:
    """Return the functions and classes of a module without its protocols; anything else as it is."""
    if not inspect.ismodule(part):
        return [part]
    own = [each for each in vars(part).values() if getattr(each, "__module__", "") == part.__name__]
    return [each for each in own if Protocol not in getattr(each, "__bases__", ())]


def _constants(copied: Sequence[Any], texts: Sequence[str]) -> dict[str, object]:
    """Return the constants that functions and classes name in their text, from their modules."""
    names = [
        (node.id, vars(sys.modules[each.__module__]))
        for each, text in zip(copied, texts, strict=True)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Name) and node.id.isupper()
    ]
    return {name: module[name] for name, module in names if name in module}
