"""Arms of others, described in TOML, act as the one that comes with wmspec does."""

from functools import cache
from math import radians
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

import wmspec
from tests.command import wmspec as command
from tests.engines import installed, quick
from wmspec.compile.robots.arm import solve
from wmspec.compile.robots.arm_assets import read_arm, write_arm
from wmspec.core.diagnostics import WmsError

pytest.importorskip("pybullet_data")

HAND = """
[hand]
on = "{on}"
at = {at}
palm = [0.06, 0.19, 0.06]
fingers = [0.021, 0.02, 0.06]
opening = 0.08
grip = 60
"""
IIWA = """package = "pybullet_data"
file = "kuka_iiwa/model.urdf"
rest = [0, 5, 0, -105, 0, 70, 0]
speed = [98, 98, 100, 130, 140, 180, 180]
""" + HAND.format(on="lbr_iiwa_link_7", at="[0, 0, 0.045]")
XARM = """package = "pybullet_data"
file = "xarm/xarm6_with_gripper.urdf"
rest = [0, -20, -60, 0, 80, 0]
speed = [180]
""" + HAND.format(on="link6", at="[0, 0, 0]")
#: Two hinges and a fixed forearm in MJCF, which names neither masses nor limits.
CRANE = """<mujoco><worldbody><body name="post">
  <geom size="0.05 0.1" type="cylinder" pos="0 0 0.1"/>
  <body name="boom" pos="0 0 0.2">
    <joint name="swing" axis="0 0 1" range="-170 170"/>
    <geom size="0.2 0.02 0.02" type="box" pos="0.2 0 0"/>
    <body name="wrist" pos="0.4 0 0"><joint name="roll" axis="0 0 -1"/><geom size="0.03"/></body>
  </body>
</body></worldbody></mujoco>"""
STAGE = """#usda 1.0
(
  defaultPrim = "crane"
  metersPerUnit = 1
  upAxis = "Z"
)
def Xform "crane" {
  def Cube "post" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {
    double size = 0.1
  }
  def Cube "boom" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {
    double size = 0.1
    double3 xformOp:translate = (0, 0, 0.2)
    uniform token[] xformOpOrder = ["xformOp:translate"]
  }
  def Cube "wrist" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {
    double size = 0.1
    double3 xformOp:translate = (0.4, 0, 0.2)
    uniform token[] xformOpOrder = ["xformOp:translate"]
  }
  def PhysicsRevoluteJoint "swing" {
    rel physics:body0 = </crane/post>
    rel physics:body1 = </crane/boom>
    uniform token physics:axis = "Z"
    point3f physics:localPos0 = (0, 0, 0.2)
    float physics:lowerLimit = -170
    float physics:upperLimit = 170
  }
  def PhysicsRevoluteJoint "roll" {
    rel physics:body0 = </crane/boom>
    rel physics:body1 = </crane/wrist>
    uniform token physics:axis = "Z"
    point3f physics:localPos0 = (0.4, 0, 0)
  }
}
"""
PICK = """use tabletop
task pick : custom {
  robot mine : arm { model: "mine.usdc"  on: table at (0, 25 cm)  yaw: -90 deg }
  object cup { shape: box  size: (6 cm, 5 cm, 6 cm)  density: 500 kg/m^3  on: table at (-4 cm, -20 cm) }
  object mat { shape: box  size: (16 cm, 16 cm, 1 cm)  on: table at (14 cm, -20 cm)  fixed: true }
  action grab  = mine.pick(cup, height: 12 cm) for 3.4 s
  action twist = mine.rotate(cup, angle: 40 deg) for 2 s after grab
  action put   = mine.place(cup, on: mat, at: (1 cm, 2 cm)) for 5 s after twist
  horizon 10.6 s
  observe front at [0 s]
}"""


def written(folder: Path, description: str) -> Path:
    """The file of an arm, and a spec that uses it beside it."""
    (folder / "mine.toml").write_text(description)
    write_arm(folder / "mine.toml", folder / "mine.usdc")
    (folder / "pick.wms").write_text(PICK)
    return folder / "mine.usdc"


@cache
def packaged(description: str) -> bytes:
    """The file of an arm whose model is in a package: made once."""
    with TemporaryDirectory() as folder:
        return written(Path(folder), description).read_bytes()


def placed(folder: Path, description: str) -> Path:
    """The same as `written`, of an arm whose model is in a package."""
    (folder / "mine.usdc").write_bytes(packaged(description))
    (folder / "pick.wms").write_text(PICK)
    return folder / "mine.usdc"


@pytest.mark.parametrize("engine", quick("pybullet"))
@pytest.mark.parametrize("arm", [IIWA, pytest.param(XARM, marks=pytest.mark.slow)], ids=["iiwa", "xarm6"])
def test_it_picks_turns_and_puts_down(tmp_path: Path, arm: str, engine: str) -> None:
    installed(engine)
    placed(tmp_path, arm)
    cup = wmspec.load(tmp_path / "pick.wms")[0].run(engine)["cup"]
    assert cup.position[-1] - cup.position[0] == pytest.approx([0.19, 0.02, 0.01], abs=2e-4)
    assert cup.orientation[-1][[0, 3]] == pytest.approx([np.cos(radians(20)), np.sin(radians(20))], abs=5e-4)


@pytest.mark.parametrize("arm", [IIWA, pytest.param(XARM, marks=pytest.mark.slow)], ids=["iiwa", "xarm6"])
def test_tool_reaches_its_target(tmp_path: Path, arm: str) -> None:
    mine = read_arm(placed(tmp_path, arm))
    start = mine.tool(mine.rest, np.eye(4))
    assert start[:3, 2] == pytest.approx([0, 0, -1], abs=0.35)
    for step in np.eye(3):
        target = start.copy()
        target[:3, 3] += 0.05 * step
        angles = solve(mine, target, np.eye(4), mine.rest)
        assert angles is not None
        assert mine.tool(angles, np.eye(4)) == pytest.approx(target, abs=1e-5)


@pytest.mark.parametrize("file", ["crane.xml", "crane.usda"])
def test_an_arm_of_mjcf_or_usd_keeps_its_limits(tmp_path: Path, file: str) -> None:
    (tmp_path / file).write_text(CRANE if file == "crane.xml" else STAGE)
    text = f'file = "{file}"\nrest = [30, 0]\n' + HAND.format(on="wrist", at="[0, 0, -0.1]") + "turn = [180, 0, 0]\n"
    mine = read_arm(written(tmp_path, text))
    assert np.degrees(mine.low[0]) == pytest.approx(-170)
    reach = 0.4 * np.array([np.cos(radians(30)), np.sin(radians(30))])
    assert mine.tool(mine.rest, np.eye(4))[:3, 3] == pytest.approx([*reach, 0.2 - 0.1 - 0.06 - 0.06 + 0.0095])


def test_its_stage_stands_by_itself(tmp_path: Path) -> None:
    installed("mujoco")
    placed(tmp_path, IIWA)
    command("compile", "pick.wms", "-o", "out", folder=tmp_path)
    (tmp_path / "mine.usdc").unlink()
    (stage,) = (tmp_path / "out").rglob("000000.usda")
    cup = wmspec.run(stage, "mujoco")["cup"]
    assert cup.position[-1] - cup.position[0] == pytest.approx([0.19, 0.02, 0.01], abs=2e-4)


def test_which_arm_it_is_can_be_a_factor(tmp_path: Path) -> None:
    placed(tmp_path, IIWA)
    (tmp_path / "other.usdc").write_bytes((tmp_path / "mine.usdc").read_bytes())
    text = PICK.replace("robot mine", 'factor which in ["mine.usdc", "other.usdc"]\n  robot mine').replace(
        '"mine.usdc"  on', "which  on"
    )
    (tmp_path / "pick.wms").write_text(text)
    command("compile", "pick.wms", "-i", "1", "-o", "out", folder=tmp_path)
    (stage,) = (tmp_path / "out").rglob("000001.usda")
    assert "assets/other-" in stage.read_text() + (stage.parent / "base.usda").read_text()
    assert wmspec.open_stage(stage).GetPrimAtPath("/World/Objects/mine/hand")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"lbr_iiwa_link_7"', '"lbr_iiwa_link_9"', "there is no link `lbr_iiwa_link_9`"),
        ("rest = [0, ", "rest = [", "`rest` has 6 numbers, and 7 hinges lead to"),
        ("grip = 60", "grip = -60", "`hand.grip`: "),
        ("grip = 60", "grap = 60", "`hand.gr[ia]p`: "),
        ("pybullet_data", "no_such_package", "there is no package `no_such_package`"),
        ("model.urdf", "no_model.urdf", "no_model.urdf"),
        ("rest =", "rest", "is no TOML"),
    ],
)
def test_errors_of_a_description_are_reported(tmp_path: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(WmsError, match=message):
        written(tmp_path, IIWA.replace(old, new, 1))


def test_file_without_an_arm_is_an_error(tmp_path: Path) -> None:
    placed(tmp_path, IIWA)
    (tmp_path / "mine.usdc").write_text("#usda 1.0\n")
    with pytest.raises(WmsError, match=r"mine.usdc is no arm"):
        wmspec.load(tmp_path / "pick.wms")[0].stage()
