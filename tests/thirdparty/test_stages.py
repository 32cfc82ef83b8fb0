"""Stages that others wrote, by hand or by converters: they run alike in the engines, or are refused for a reason."""

from __future__ import annotations

import subprocess
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from tests.engines import ENGINES, installed
from tests.physics.scenes import scene
from tests.physics.test_joints import joint, rod
from tests.thirdparty.environments import CACHE, PIP, python_with
from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Force, Scene, Trace
from wmspec.sim.usd import read

pytestmark = pytest.mark.slow

NEWTON = "newton==1.8.0"
RUNS = {  # stages of Newton, with stand-ins where needed -> how far (mm) the engines may be apart after half a second
    "examples/assets/cartpole_single_pendulum.usda": 0.1,
    "examples/assets/palletizer_scene.usda": 0.5,
    "examples/assets/crazyflie.usd": 0.5,
    "examples/assets/bunny.usd": 0.5,
    "examples/assets/curvedSurface.usd": 0.5,
    "tests/assets/cartpole_mjc.usda": 0.1,
    "tests/assets/simple_articulation_with_mesh.usda": 0.1,
    "tests/assets/negative_scale_mesh_pair.usda": 0.5,
    "tests/assets/kamino/basics/cartpole.usda": 0.1,
    "tests/assets/kamino/testing/joints/test_joint_fixed.usda": 0.1,
    "tests/assets/kamino/testing/joints/test_joint_spherical.usda": 0.1,
    "tests/assets/kamino/testing/joints/test_joint_revolute_passive.usda": 0.1,
    "tests/assets/kamino/testing/joints/test_joint_prismatic_passive_unary.usda": 0.1,
    "tests/assets/kamino/testing/joints/test_joint_d6_prismatic_actuated.usda": 0.1,
}
REFUSED = {  # without stand-ins
    "examples/assets/boxes_fourbar.usda": "/boxes_fourbar/Joints/joint_4: it closes a loop of joints",
    "examples/assets/ant.usda": "/ant/joints/front_left_leg: physxLimit:angular:damping",
    "examples/assets/humanoid.usda": "/nv_humanoid/joints/lower_waist: a joint that leaves rotX, rotY free",
    "examples/assets/rj45_plug.usd": "/World/CableCurve: this kind of geometry is not supported",
    "tests/assets/deformables_mixed.usda": "/World/CableA: particles and deformable bodies are not supported",
    "tests/assets/four_link_chain_articulation.usda": "/Articulation/Joint1: drive:angular:physics:damping",
    "tests/assets/kamino/basics/box_on_plane.usda": "filteredGroups -> /boxes_hinged/Collisions is not on the stage",
    "tests/assets/kamino/basics/box_pendulum.usda": "physics -> /box_on_plane/Materials/Concrete is not on the stage",
    "tests/assets/kamino/basics/boxes_hinged.usda": "/World: newton:kamino:padmm:complementarityTolerance",
    "tests/assets/kamino/testing/geoms/test_geom_ellipsoid.usda": "its scale makes its round section elliptic",
}


@pytest.fixture(scope="session")
def newton() -> Path:
    """The files of the Newton package, which is not installed."""
    folder = CACHE / NEWTON
    if not (folder / "newton").is_dir():
        wheels = CACHE / "wheels"
        done = subprocess.run([*PIP, "download", "-q", "--no-deps", "-d", str(wheels), NEWTON], check=False)
        if done.returncode:
            pytest.skip(f"needs {NEWTON}, and no package registry can be reached")
        with zipfile.ZipFile(next(wheels.glob("newton-*.whl"))) as wheel:
            wheel.extractall(folder)
    return folder / "newton"


def opened(path: Path, duration: float = 0.5, *, strict: bool = False) -> Scene:
    """The scene of a stage, for a while."""
    return replace(read(Usd.Stage.Open(str(path)), strict=strict), duration=duration)


def traces(play: Scene) -> Iterator[Trace]:
    """What happens in every engine that is installed."""
    for engine in ENGINES:
        if find_spec(engine):
            yield installed(engine).execute(play)


def apart(found: list[Trace]) -> float:
    """The largest distance (mm) of a body from itself in another engine."""
    return max(1000 * float(np.abs(a.position - found[0].position).max()) for a in found)


@pytest.mark.parametrize("name", RUNS)
def test_a_stage_of_newton_runs_alike_in_the_engines(newton: Path, name: str) -> None:
    play = opened(newton / name)
    assert play.bodies
    assert apart(list(traces(play))) < RUNS[name]


@pytest.mark.parametrize("name", REFUSED)
def test_a_stage_of_newton_is_refused_for_its_reason(newton: Path, name: str) -> None:
    with pytest.raises(WmsError, match=REFUSED[name].replace("(", r"\(")):
        list(traces(opened(newton / name, strict=True)))


def test_every_stage_of_newton_runs_or_is_refused(newton: Path) -> None:
    """No other error than ours, whose remedies a user reads."""
    ran, refused = 0, 0
    for path in sorted(newton.rglob("*.usd*")):
        if "ant_multi" in path.name:
            continue  # 64 times the ant
        try:
            ran += len([trace for trace in traces(opened(path, 0.02)) if np.isfinite(trace.position).all()])
        except WmsError:
            refused += 1
    assert ran > 3 * 30
    assert refused > 15


def test_a_robot_converted_from_urdf_falls_alike(tmp_path: Path) -> None:
    """A KUKA arm without motors stands up until something pushes it; another has a link without mass."""
    data = find_spec("pybullet_data")
    if data is None or data.origin is None:
        pytest.skip("needs PyBullet's models")
    models = Path(data.origin).parent
    arm = converted("urdf-usd-converter", models / "kuka_iiwa/model.urdf", tmp_path / "arm")
    play = opened(arm)
    assert [j.kind for j in play.joints] == ["fixed"] + ["hinge"] * 7
    push = Force("push", play.bodies[5].name, 0.0, 0.1, np.array([12.0, 4.0, 0.0]))
    found = list(traces(replace(play, actions=(push,))))
    assert apart(found) < 1.0
    assert np.abs(found[0].position[-1] - found[0].position[0]).max() > 0.05
    panda = converted("urdf-usd-converter", models / "franka_panda/panda.urdf", tmp_path / "panda")
    with pytest.raises(WmsError, match="panda_link8: a dynamic body without colliders has no mass"):
        opened(panda, strict=True)


def test_our_own_mjcf_converted_to_usd_swings_as_before(tmp_path: Path) -> None:
    """Scene -> MJCF -> a stage by NVIDIA's converter -> the same scene."""
    backend = installed("mujoco")
    upper, lower = rod("upper", 0.5), rod("lower", 0.5, at=(-np.sin(0.5), 0, -np.cos(0.5)))
    elbow = (-np.sin(0.5), 0, -np.cos(0.5))
    joints = (joint("shoulder", "hinge", None, upper, (0, 0, 0)), joint("elbow", "hinge", upper, lower, elbow))
    play = scene(upper, lower, joints=joints, duration=0.5)
    (tmp_path / "scene.xml").write_text(backend.native(play)["scene.xml"])
    again = opened(converted("mujoco-usd-converter", tmp_path / "scene.xml", tmp_path / "usd"))
    expected = backend.execute(play)
    for trace in traces(again):
        for name in ("upper", "lower"):
            error = trace.position[:, trace.bodies.index(name)] - expected.position[:, expected.bodies.index(name)]
            assert np.abs(error).max() < 1e-3


def converted(tool: str, source: Path, into: Path) -> Path:
    """The stage that a converter, in its own environment, makes of a model."""
    program = python_with(tool).parent / tool.replace("-", "_")
    subprocess.run([str(program), str(source), str(into)], check=True, capture_output=True)
    (stage,) = [path for path in into.iterdir() if path.suffix == ".usda"]
    return stage
