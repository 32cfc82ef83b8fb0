"""Assets in motion, in every engine: a pendulum against its analytic period, and a cabinet that is opened."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec
from math import pi, radians, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.assets.specs import CABINET, here, named, scene, spec
from tests.assets.test_usd_meshes import written
from tests.command import wmspec
from tests.engines import ENGINES, installed
from wmspec.sim.scene.model import Array, Pose, Scene, Trace
from wmspec.sim.scene.model.bounds import world_box

#: What tests/assets/pendulum.urdf says: mass (kg), from the pivot to the centre of mass (m), moment about that (kg m²).
MASS, ARM, MOMENT = 0.8, 0.3, 0.02


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> str:
    installed(request.param)
    return str(request.param)


def executed(engine: str, found: Scene) -> Trace:
    trace: Trace = installed(engine).execute(found)
    return trace


def track(trace: Trace, found: Scene, name: str) -> Array:
    """Where the frame of a body is (T, 3), m."""
    i = [b.name for b in found.bodies].index(name)
    return np.asarray(trace.position[:, i])


@pytest.mark.parametrize("gravity", [9.81, 1.62])
def test_a_pendulum_keeps_its_period(engine: str, tmp_path: Path, gravity: float) -> None:
    """T = 2π √(I / m g d), I about the pivot; at 5° of amplitude it is 0.05 % longer."""
    expected = 2 * pi * sqrt((MOMENT + MASS * ARM**2) / (MASS * gravity * ARM)) * (1 + radians(5) ** 2 / 16)
    swings = f'world {{ gravity: {gravity} m/s^2 }}\nobject pendulum {{ file: "pendulum.urdf"  at: (0, 0, 0)\n'
    found = scene(spec(f"{swings}part pivot {{ start: 5 deg }} }}", here(tmp_path), 3.2 * expected))
    trace = executed(engine, found)
    i = [b.name for b in found.bodies].index("pendulum")
    angle = 2 * np.arctan2(trace.orientation[:, i, 2], trace.orientation[:, i, 0])
    assert angle[0] == pytest.approx(radians(5), abs=1e-6)
    up = np.flatnonzero((angle[:-1] < 0) & (angle[1:] >= 0))
    crossings = trace.time[up] - angle[up] / np.diff(angle)[up] * np.diff(trace.time)[up]
    assert len(crossings) == 3
    assert np.diff(crossings) == pytest.approx(expected, rel=2e-3)


def test_a_cabinet_is_opened(engine: str, tmp_path: Path) -> None:
    """Drives take the door and the drawer to their targets, wherever the cabinet stands; the rest stays."""
    body = """object cabinet {
      file: "cabinet.urdf"  at: (1 m, 0, 0)  yaw: 90 deg  fixed: true
      part hinge { stiffness: 20  damping: 4 }
      part rail { start: 5 cm  stiffness: 200  damping: 30  target: 5 cm }
    }
    action open = drive(cabinet.hinge, 60 deg)
    action pull = drive(cabinet.rail, 20 cm) at 0.5 s"""
    found = scene(spec(body, here(tmp_path), 3.0))
    trace = executed(engine, found)
    drawer = track(trace, found, "cabinet_drawer")
    assert drawer[0] == pytest.approx((1.05, 0, 0.47), abs=1e-6)
    assert drawer[-1] == pytest.approx((1.2, 0, 0.47), abs=2e-3)
    i = [b.name for b in found.bodies].index("cabinet_door")
    w, _, _, z = trace.orientation[-1, i]
    assert 2 * np.arctan2(z, w) == pytest.approx(radians(90 - 60), abs=0.02)
    assert track(trace, found, "cabinet_door")[-1] == pytest.approx((1.19, -0.23, 0.18), abs=2e-3)


def test_documented_cabinet_runs(tmp_path: Path) -> None:
    """Compiled with its counterfactuals, run in every engine, and all of them say where door and drawer end."""
    page = CABINET.with_name("guides").joinpath("assets.md").read_text()
    spec_file = here(tmp_path) / "open.wms"
    spec_file.write_text(page.partition("```wms cabinet\n")[2].partition("```")[0])
    engines = [e for e in ENGINES if find_spec(e)]
    wmspec("compile", "open.wms", "-i", "2", "-o", "out", "--backend", engines[0], folder=tmp_path)
    assert {p.name.partition(".")[2] for p in (tmp_path / "out/open").glob("000002.*.usda")} == {
        "little.usda",
        "none.usda",
        "stuck.usda",
    }
    said = wmspec("run", "open.wms", "--backend", ",".join(engines), folder=tmp_path).stdout
    assert said.count("cabinet_door     ends at") == len(engines)


def test_a_mesh_of_usd_falls_and_rests_as_the_cube_that_it_is(engine: str, tmp_path: Path) -> None:
    """In centimetres, y up, mirrored: it lands on its lower face and stays there."""
    said: dict[str, Any] = {"meters": 0.01, "up": "Y", "scale": (-3, 3, 3), "turn": -1}
    written(tmp_path, "mesh.usda", **said)
    written(tmp_path, "cube.usda", "Cube", form="double size = 2", **said)
    floor = "object floor_ { shape: plane  size: 4 m  at: (0, 0, 0)  fixed: true }"
    ends = []
    for name in ("mesh", "cube"):
        falls = f'object a {{ file: "{name}.usda"  at: (0, 0, 15 cm)  yaw: 10 deg  restitution: 0 }}'
        found = scene(spec(f"{floor}\n{falls}", tmp_path, 2.0))
        trace = executed(engine, found)
        i = [b.name for b in found.bodies].index("a")
        bodies = replace(named(found, "a"), pose=Pose(trace.position[-1, i], trace.orientation[-1, i]))
        ends.append(world_box(bodies.geoms, bodies.pose))
        assert np.linalg.norm(trace.position[-1, i] - trace.position[-10, i]) < 1e-4
    for low, high in ends:
        assert low[2] == pytest.approx(0, abs=1e-3)
        assert high[2] == pytest.approx(0.06, abs=2e-3)
