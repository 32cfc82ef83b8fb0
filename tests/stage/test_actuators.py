"""Actuators of MuJoCo and Newton in stages: servos are drives, others are warned about."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.stage.test_layer_metrics import written
from wmspec.core.diagnostics import StageError
from wmspec.sim.scene.model import Scene
from wmspec.sim.usd import read
from wmspec.sim.usd.files import open_stage_file

LEVER = """
def Xform "World"
{{
    def Cube "A" ( prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"] )
    {{
        double size = 0.2
    }}
    def PhysicsRevoluteJoint "j" ( {apis} )
    {{
        rel physics:body1 = </World/A>
        {drive}
    }}
    {actuators}
}}
"""
DRIVE = """float drive:angular:physics:stiffness = 1.7453292519943295
        float drive:angular:physics:targetPosition = 57.29577951308232"""


def mjc(more: str = "", bias: str = "0, -200, -20") -> str:
    """An affine actuator on the joint, named a; without `bias`, a motor."""
    said = f'token mjc:biasType = "affine"\ndouble[] mjc:biasPrm = [{bias}]' if bias else ""
    return f'def MjcActuator "a"\n{{\nrel mjc:target = </World/j>\n{said}\n{more}\n}}\n'


def scene(tmp_path: Path, actuators: str, *, driven: bool = False, strict: bool = False) -> Scene:
    apis = 'prepend apiSchemas = ["PhysicsDriveAPI:angular"]' if driven else ""
    text = LEVER.format(actuators=actuators, apis=apis, drive=DRIVE if driven else "")
    return read(open_stage_file(written(tmp_path / "a.usda", text), "a.usda"), strict=strict)


def test_a_position_actuator_is_a_drive(tmp_path: Path) -> None:
    found = scene(
        tmp_path, mjc("double[] mjc:gear = [3]\ndouble mjc:forceRange:min = -4\ndouble mjc:forceRange:max = 5")
    )
    (joint,) = found.joints
    assert joint.drive is not None
    assert (joint.drive.stiffness, joint.drive.damping) == pytest.approx((1800, 180))
    assert joint.drive.max_force == pytest.approx(12)
    assert not found.notes
    assert scene(tmp_path, mjc(), strict=True).joints[0].drive is not None


def test_a_velocity_actuator_holds_the_joint(tmp_path: Path) -> None:
    (joint,) = scene(tmp_path, mjc(bias="0, 0, -20")).joints
    assert joint.drive is not None
    assert (joint.drive.stiffness, joint.drive.damping, joint.drive.velocity) == (0, 20, 0)


def test_an_actuator_adds_to_the_spring_of_its_joint(tmp_path: Path) -> None:
    (joint,) = scene(tmp_path, mjc(), driven=True).joints
    assert joint.drive is not None
    assert joint.drive.stiffness == pytest.approx(300, rel=1e-6)
    assert joint.drive.target == pytest.approx(1 / 3, rel=1e-6)


def test_a_limit_beside_a_spring_limits_both(tmp_path: Path) -> None:
    limit = "double mjc:forceRange:min = -4\ndouble mjc:forceRange:max = 5"
    found = scene(tmp_path, mjc(limit), driven=True)
    assert found.joints[0].drive is not None
    assert found.joints[0].drive.max_force == 4
    (note,) = found.notes
    assert "it limits their sum" in note.message
    with pytest.raises(StageError, match="the force limit of an actuator"):
        scene(tmp_path, mjc(limit), driven=True, strict=True)


def test_a_newton_actuator_is_a_drive(tmp_path: Path) -> None:
    text = (
        'def NewtonActuator "n" ( prepend apiSchemas = ["NewtonPDControlAPI", "NewtonMaxEffortClampingAPI"] )\n{\n'
        "rel newton:targets = </World/j>\nfloat newton:kp = 400\nfloat newton:kd = 40\nfloat newton:maxEffort = 87\n}\n"
    )
    (joint,) = scene(tmp_path, text).joints
    assert joint.drive is not None
    assert (joint.drive.stiffness, joint.drive.damping, joint.drive.max_force) == (400, 40, 87)


@pytest.mark.parametrize(
    "actuator",
    [
        mjc(bias=""),
        mjc("double[] mjc:gear = [0]"),
        mjc('token mjc:dynType = "muscle"'),
        mjc(bias="0, 200, 0"),
        mjc().replace("/World/j", "/World/A"),
    ],
)
def test_another_actuator_is_left_out_with_one_note_for_its_kind(tmp_path: Path, actuator: str) -> None:
    found = scene(tmp_path, actuator + actuator.replace('"a"', '"b"'))
    assert found.joints[0].drive is None
    (note,) = found.notes
    assert "here and on 1 other" in note.message
    assert "left out" in note.message
    with pytest.raises(StageError, match="actuator"):
        scene(tmp_path, actuator, strict=True)
