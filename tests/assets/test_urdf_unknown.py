"""Every element of a URDF reports the children and attributes that it does not have."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from tests.assets.specs import checked

ROBOT = """<robot name="r">
  <material name="paint"><color rgba="1 0 0 1"/></material>
  <link name="a">
    <inertial>
      <origin xyz="0 0 0"/><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <visual><geometry><box size=".2 .2 .2"/></geometry><material name="own"><color rgba="0 1 0 1"/></material></visual>
    <visual><geometry><cylinder radius=".1" length=".2"/></geometry><material name="paint"/></visual>
    <collision><geometry><sphere radius=".2"/></geometry></collision>
    <contact><lateral_friction value="0.2"/><restitution value="0.3"/></contact>
  </link>
  <link name="b">
    <inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><capsule radius=".1" length=".2"/></geometry></collision>
  </link>
  <joint name="j" type="revolute">
    <parent link="a"/><child link="b"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/><dynamics damping="0.1"/><mimic joint="j" multiplier="1"/>
  </joint>
</robot>"""
#: Each element by its place in the file.
ELEMENTS = list(enumerate(element.tag for element in ET.fromstring(ROBOT).iter()))


def reported(robot: ET.Element, folder: Path) -> list[str]:
    """Return what a spec with this file reports."""
    (folder / "a.urdf").write_bytes(ET.tostring(robot))
    (folder / "spec.wms").write_text('task t : custom {\n  object it { file: "a.urdf"  at: (0, 0, 1 m) }\n}\n')
    return [d.message for d in checked(folder / "spec.wms")[1].diagnostics if d.code in ("WMS210", "WMS211")]


def test_the_robot_itself_has_nothing_unknown(tmp_path: Path) -> None:
    (mimic,) = reported(ET.fromstring(ROBOT), tmp_path)
    assert "mimics another" in mimic


@pytest.mark.parametrize(("place", "tag"), ELEMENTS)
def test_an_unknown_child_or_attribute_is_reported(place: int, tag: str, tmp_path: Path) -> None:
    robot = ET.fromstring(ROBOT)
    element = list(robot.iter())[place]
    element.append(ET.Element("oddity"))
    element.set("peculiar", "1")
    (child,) = (m for m in reported(robot, tmp_path) if "`oddity`" in m or "one shape" in m)
    assert tag == "geometry" or f"`oddity` in `{tag}` is not supported: ignored" in child
    element.remove(element[-1])
    (attribute,) = (m for m in reported(robot, tmp_path) if "peculiar" in m)
    assert f"`peculiar` of `{tag}` is not supported: ignored" in attribute


@pytest.mark.parametrize(("place", "tag"), ELEMENTS)
def test_prefixed_attributes_belong_to_other_programs(place: int, tag: str, tmp_path: Path) -> None:
    robot = ET.fromstring(ROBOT)
    list(robot.iter())[place].set("other:peculiar", "1")
    assert len(reported(robot, tmp_path)) == 1
