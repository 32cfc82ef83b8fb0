"""Colours that questions name stay apart as they are drawn: in the lights of the libraries, in light and shade."""

from __future__ import annotations

from collections.abc import Collection
from itertools import combinations
from typing import Any

import numpy as np
import pytest

import wmspec
from tests.engines import ENGINES, installed
from tests.pixels.test_palette import HUES, seen
from tools import worlds
from wmspec.runtime.questions.difference import ciede2000
from wmspec.sim.materials import DISTINCT_COLORS
from wmspec.sim.usd import read

OBJECT = "  object a_{0} {{ shape: shape  size: {1}  color: {0}  on: here.{2} at ({3} * {1}, {4} * {1}) }}\n"
TASK = """
use {library} as here
task drawn : custom {{
  factor shape in [sphere, cube, cylinder]
{objects}
  observe here.front at [0 s]
}}
"""
#: A library of each light, where objects stand, and their size.
PLACES = {
    "grounds": ("ground", "16 cm"),
    "tables": ("ground", "9 cm"),
    "places": ("floor", "16 cm"),
    "room": ("floor", "12 cm"),
    "room_cool": ("floor", "12 cm"),
    "room_dark": ("floor", "12 cm"),
    "tabletop_dark": ("table", "7 cm"),
    "terrace": ("floor", "16 cm"),
}


def drawn(library: str, engine: str, shapes: Collection[str] = ("sphere", "cube", "cylinder")) -> dict[str, Any]:
    """Mean sRGB of the objects of every colour: (shapes, 3)."""
    ground, size = PLACES[library]
    objects = "".join(
        OBJECT.format(name, size, ground, 1.7 * (i % 4 - 1.5), 2 * (i // 4 - 1))
        for i, name in enumerate(DISTINCT_COLORS)
    )
    task = wmspec.load(text=TASK.format(library=library, objects=objects))
    means: dict[str, list[Any]] = {name: [] for name in DISTINCT_COLORS}
    for instance in [{instance.factors["shape"]: instance for instance in task[:24]}[shape] for shape in shapes]:
        scene = read(instance.stage())
        (frame,) = worlds.frames(scene, engine, 192, ["front"])
        for i, body in enumerate(scene.bodies):
            if (name := body.name.removeprefix("a_")) in means:
                means[name].append(frame.rgb[frame.ids == i].mean(axis=0) / 255)
    return {name: np.array(colors) for name, colors in means.items()}


@pytest.mark.engine
@pytest.mark.parametrize("library", PLACES)
def test_names_stay_apart_as_drawn(library: str) -> None:
    installed("mujoco")
    colors = drawn(library, "mujoco")
    for deficiency in ("none", "protan", "deutan"):
        for one, other in combinations(DISTINCT_COLORS if deficiency == "none" else HUES, 2):
            first, second = seen(colors[one], deficiency), seen(colors[other], deficiency)
            apart = ciede2000(first[:, None], second[None]).min()
            assert apart >= (15 if deficiency == "none" else 8), f"{one} and {other}, {deficiency}: {apart:.1f}"


@pytest.mark.engine
@pytest.mark.parametrize("engine", [engine for engine in ENGINES if engine != "mujoco"])
def test_all_engines_draw_them_distinct(engine: str) -> None:
    """On spheres, which have a side in the light and one in the shade."""
    installed(engine)
    colors = drawn("grounds", engine, ["sphere"])
    for one, other in combinations(DISTINCT_COLORS, 2):
        assert ciede2000(seen(colors[one], "none")[:, None], seen(colors[other], "none")[None]).min() >= 15
