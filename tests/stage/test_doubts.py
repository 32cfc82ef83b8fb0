"""Doubtful contents of a stage are executed as written, and reported."""

from __future__ import annotations

import pytest
from pxr import Usd

from usdphysics_conformance.stages import body, box, floor, joint, stage
from wmspec.sim.scene.model import Scene
from wmspec.sim.usd import read

CUBE = box(0.1, 0.1, 0.1)


def reported(text: str) -> list[str]:
    made = Usd.Stage.CreateInMemory()
    made.GetRootLayer().ImportFromString(text)
    scene: Scene = read(made, strict=False)
    return [str(note) for note in scene.notes]


@pytest.mark.parametrize(("height", "depth"), [(0.03, "20"), (0.044, "6"), (0.046, ""), (0.05, ""), (0.2, "")])
def test_initial_overlap_is_reported_from_5_mm_on(height: float, depth: str) -> None:
    notes = reported(stage(floor(), body("cube", CUBE, (0, 0, height))))
    assert [f"/World/cube: it starts {depth} mm inside /World/floor" in note for note in notes] == [True] * bool(depth)


def test_filtered_and_jointed_pairs_may_overlap() -> None:
    pair = body("one", CUBE), body("other", CUBE, (0.05, 0, 0)), joint("Fixed", "j", "one", "other", (0.05, 0, 0))
    assert not reported(stage(*pair))
    assert reported(stage(*pair[:2]))


def test_several_joints_between_two_bodies_are_reported_and_lock() -> None:
    bodies = body("one", CUBE), body("other", CUBE, (0.5, 0, 0))
    hinges = [joint("Revolute", f"about_{axis}", "one", "other", (0.25, 0, 0), (-0.25, 0, 0), axis) for axis in "XY"]
    (note,) = [note for note in reported(stage(*bodies, *hinges)) if "same two bodies" in note]
    assert note.startswith("/World/about_X: it joins the same two bodies as /World/about_Y")
    assert not [note for note in reported(stage(*bodies, hinges[0])) if "same two bodies" in note]
