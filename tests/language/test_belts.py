"""Belts: fixed objects whose surface moves."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.assets.specs import scene, spec
from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.core.diagnostics import SpecError
from wmspec.sim.usd import read

SPEC = """use room

task t : custom {{
  factor pace in [0 cm/s, 20 cm/s]
  object belt {{ shape: box  size: (60 cm, 20 cm, 4 cm)  at: (0, 0, 10 cm)  {0} }}
  object load {{ shape: cube  size: 7 cm  on: belt at (0, 0) }}
  observe front at [0 s, 1 s]
}}
"""


def test_a_belt_is_a_kinematic_body_with_the_surface_velocity_of_the_spec() -> None:
    task = task_from(SPEC.format("yaw: 90 deg  fixed: true  surface_velocity: (pace, 0, 0)"))
    design = Design(task)
    for index in range(len(design)):
        scene = read(compose(document(task, design[index])))
        belt = next(body for body in scene.bodies if body.name == "belt")
        assert belt.motion == "kinematic"
        assert belt.surface_velocity == pytest.approx((design[index].values["pace"], 0, 0))


@pytest.mark.parametrize(
    ("properties", "expected"),
    [
        ("surface_velocity: (pace, 0, 0)", "`belt` has a `surface_velocity` and is not fixed"),
        ("surface_velocity: (pace, 0, 0)  fixed: true  solid: false", "its surface carries nothing"),
    ],
)
def test_other_objects_have_no_surface_velocity(properties: str, expected: str) -> None:
    task = task_from(SPEC.format(properties).replace("on: belt at (0, 0)", "at: (0, 0, 1 m)"))
    with pytest.raises(SpecError, match=expected):
        document(task, Design(task)[0])


def test_a_belt_of_a_file_keeps_its_surface_velocity(tmp_path: Path) -> None:
    (tmp_path / "line.usda").write_text("""#usda 1.0
(
    defaultPrim = "line"
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "line" {
    def Cube "belt" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysxSurfaceVelocityAPI"]
    ) {
        double size = 0.5
        bool physics:kinematicEnabled = true
        vector3f physxSurfaceVelocity:surfaceVelocity = (0.25, 0, 0)
    }
}
""")
    (belt,) = (b for b in scene(spec('object line { file: "line.usda"  at: (0, 0, 1 m) }', tmp_path)).bodies)
    assert (belt.motion, belt.surface_velocity) == ("kinematic", (0.25, 0, 0))
