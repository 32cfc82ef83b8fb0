"""Attributes about motion that no engine reads are reported, once a kind; redundant ones are not."""

from __future__ import annotations

import pytest

from tests.stage.stages import stage
from wmspec.core.diagnostics import StageError
from wmspec.sim.usd import read

BALL = 'def Sphere "%s" ( prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"] ) { %s }\n'
JOINT = 'def PhysicsRevoluteJoint "j" { %s\n %s }\n'
HELD = "rel physics:body1 = </World/b>"

SAID = {
    "gravity that is off": (BALL % ("b", "bool physxRigidBody:disableGravity = 1"), "physxRigidBody:disableGravity is"),
    "gyroscopic forces that are off": (
        BALL % ("b", "bool physxRigidBody:enableGyroscopicForces = 0"),
        "enableGyroscopicForces is",
    ),
    "a joint's friction": (
        BALL % ("b", "") + JOINT % (HELD, "double mjc:frictionloss = 5 double mjc:stiffness = 1"),
        "mjc:frictionloss, mjc:stiffness are specific to another engine",
    ),
    "a joint's state": (
        BALL % ("b", "") + JOINT % (HELD, "float state:angular:physics:position = 30"),
        "state:angular:physics:position is",
    ),
    "a velocity of no body": (
        'def Cube "b" ( prepend apiSchemas = ["PhysicsCollisionAPI"] ) { vector3f physics:velocity = (1, 0, 0) }',
        "physics:velocity is of PhysicsRigidBodyAPI, which is not applied: ignored",
    ),
    "a mass without its schema": (
        BALL % ("b", "float physics:mass = 3"),
        "physics:mass is of PhysicsMassAPI, which is not applied: still read",
    ),
    "a drive without its schema": (
        BALL % ("b", "") + JOINT % (HELD, "float drive:angular:physics:stiffness = 3"),
        "drive:angular:physics:stiffness is of PhysicsDriveAPI:angular, which is not applied: ignored",
    ),
    "a velocity of another name": (
        BALL % ("b", "vector3f physics:linearVelocity = (1, 0, 0)"),
        "physics:linearVelocity is of a schema that is not applied: ignored; did you mean physics:velocity?",
    ),
    "a misspelt schema": (
        'def Cube "b" ( prepend apiSchemas = ["PhysicsRigidBody"] ) { }',
        "UsdPhysics has no schema PhysicsRigidBody: ignored; did you mean PhysicsRigidBodyAPI?",
    ),
    "an actuator": (
        BALL % ("b", "") + JOINT % (HELD, "") + 'def MjcActuator "servo" { rel mjc:target = </World/j> }',
        "an actuator that is no position or velocity actuator needs a control: left out",
    ),
    "a prim of an unknown type that acts on a body": (
        BALL % ("b", "") + 'def FancyMagnet "m" { rel magnet:body = </World/b> }',
        "the type FancyMagnet, acting on /World/b, is not supported",
    ),
    "a joint of nothing": (BALL % ("b", "") + JOINT % ("", ""), "a joint without bodies: ignored"),
}
"""Name -> the prims, and the note."""

SILENT = {
    "defaults": BALL % ("b", "bool physxRigidBody:disableGravity = 0 float newton:friction = 0"),
    "how an engine computes": BALL % ("b", "int physxRigidBody:solverPositionIterationCount = 8"),
    "what is read": BALL % ("b", "float physxRigidBody:linearDamping = 0.5"),
    "what is endless": BALL % ("b", "") + JOINT % (HELD, "float physxJoint:maxJointVelocity = inf"),
    "a velocity of zero": BALL % ("b", "vector3f physics:linearVelocity = (0, 0, 0)"),
    "a prim of an unknown type that acts on nothing": BALL % ("b", "")
    + 'def FancyLabel "m" { rel label:of = </World> }',
    "what has no part in physics": 'def Sphere "b" { float newton:mass = 3 }',
    "a schema of others": 'def Cube "b" ( prepend apiSchemas = ["PhysicsJointStateAPI:angular"] ) { }',
}


@pytest.mark.parametrize("what", SAID)
def test_unread_prims_are_reported_and_refused_when_strict(what: str) -> None:
    prims, reported = SAID[what]
    (note,) = read(stage(prims), strict=False).notes
    assert reported in str(note)
    with pytest.raises(StageError) as refused:
        read(stage(prims))
    assert [d.place for d in refused.value.diagnostics] == [note.place]


@pytest.mark.parametrize("what", SILENT)
def test_redundant_reports_are_omitted(what: str) -> None:
    assert not read(stage(SILENT[what]), strict=False).notes
    read(stage(SILENT[what]))


def test_many_prims_of_one_kind_are_one_note() -> None:
    balls = "".join(BALL % (f"b{i}", "bool physxRigidBody:disableGravity = 1") for i in range(5))
    notes = [note for note in read(stage(balls), strict=False).notes if "another engine" in str(note)]
    assert len(notes) == 1
    assert str(notes[0]).startswith("/World/b0: physxRigidBody:disableGravity (here and on 4 other prims) is")


def test_unknown_up_axis_is_reported_and_honoured() -> None:
    (note,) = read(stage(BALL % ("b", ""), up="X"), strict=False).notes
    assert "upAxis = X is neither Y nor Z: X is up" in str(note)
