"""Referenced layers with another unit or up axis: USD does not convert them, so wmspec warns."""

from __future__ import annotations

from pathlib import Path

import pytest

from wmspec.sim.usd import read
from wmspec.sim.usd.files import open_stage_file

CUBE = """
def Xform "B" ( prepend apiSchemas = ["PhysicsRigidBodyAPI"] )
{
    def Cube "c" ( prepend apiSchemas = ["PhysicsCollisionAPI"] )
    {
        double size = 20
    }
}
"""
WORLD = 'def Xform "World"\n{{\ndef Xform "R" ( references = @b.usda@ )\n{{\n{}\n}}\n}}'


def written(path: Path, text: str, metres: float = 1.0, up: str = "Z", prim: str = "World") -> Path:
    head = f'defaultPrim = "{prim}"\nmetersPerUnit = {metres}\nkilogramsPerUnit = 1\nupAxis = "{up}"'
    path.write_text(f"#usda 1.0\n(\n{head}\n)\n{text}")
    return path


def notes(tmp_path: Path, ops: str, metres: float, up: str) -> list[str]:
    written(tmp_path / "b.usda", CUBE, metres, up, "B")
    whole = written(tmp_path / "a.usda", WORLD.format(ops))
    return [note.message for note in read(open_stage_file(whole, "a.usda"), strict=False).notes]


def test_a_unit_that_is_not_converted(tmp_path: Path) -> None:
    (note,) = notes(tmp_path, "", 0.01, "Z")
    assert "b.usda has a unit of 0.01 m, and the stage one of 1 m" in note


def test_an_up_axis_that_is_not_converted(tmp_path: Path) -> None:
    (note,) = notes(tmp_path, "", 1, "Y")
    assert "b.usda has Y up, and the stage Z" in note


@pytest.mark.parametrize(
    ("ops", "metres", "up"),
    [
        ("", 1, "Z"),
        ('double3 xformOp:scale = (.01, .01, .01) uniform token[] xformOpOrder = ["xformOp:scale"]', 0.01, "Z"),
        ('double xformOp:rotateX = 90 uniform token[] xformOpOrder = ["xformOp:rotateX"]', 1, "Y"),
    ],
)
def test_no_warning_if_it_agrees_or_is_converted(tmp_path: Path, ops: str, metres: float, up: str) -> None:
    assert not notes(tmp_path, ops.replace(" uniform", "\nuniform"), metres, up)
