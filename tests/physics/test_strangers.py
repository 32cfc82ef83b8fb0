"""Stages as others write them, in odd units and axes, end where mechanics says, as `wmspec.run` executes them."""

from __future__ import annotations

from math import cos, radians, sin
from pathlib import Path

import pytest
from scipy.integrate import solve_ivp

import wmspec
from tests.engines import ENGINES, installed

HERE = Path(__file__).parent
G = 9.81


@pytest.mark.parametrize("engine", ENGINES)
def test_a_pendulum_that_is_pushed_and_a_weight_on_a_drum_in_centimetres_grams_and_y_up(engine: str) -> None:
    installed(engine)
    run = wmspec.run(HERE / "machines.usda", engine, 0.4)
    assert not run.notes
    # 1 kg on an arm of 0.5 m, with 0.01 kg m² of its own; x and y of the stage are x and z here, its z is -y
    way = solve_ivp(
        lambda _, s: [s[1], -G * 0.5 * sin(s[0]) / 0.26], (0, 0.4), [0, radians(168.107)], rtol=1e-9, atol=1e-9
    )
    out, down = 0.5 * sin(way.y[0, -1]), 0.5 * cos(way.y[0, -1])
    bob = (1 + out * cos(radians(30)), -0.5 + out * sin(radians(30)), 2 - down)
    assert run["bob"].position[-1] == pytest.approx(bob, abs=2e-3)
    fall = 2 * G / (2 + 0.05 * 5**2) / 2 * 0.4**2
    assert run["cart"].position[0, 2] - run["cart"].position[-1, 2] == pytest.approx(fall, abs=2e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_masses_are_read_in_every_form_and_instances_slide(engine: str) -> None:
    installed(engine)
    run = wmspec.run(HERE / "masses.usda", engine, 1.5)
    masses = {body.path: body.inertia.mass for body in run.scene.bodies if body.inertia}
    assert masses == pytest.approx({"/W/one/brick": 4.8, "/W/two/brick": 38.4, "/W/parts": 11.0, "/W/skew": 80.0})
    paths = {body.path: body.name for body in run.scene.bodies}
    for path, speed in (("/W/one/brick", 2.0), ("/W/two/brick", 4.0)):  # the second in a space of twice the size
        brake = 0.2 * G
        time = min(1.5, speed / brake)
        way = speed * time - brake * time**2 / 2
        assert run[paths[path]].position[-1, 0] == pytest.approx(way, rel=2e-3)
