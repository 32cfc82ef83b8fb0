"""Joints that mimic others are read in three schemas, begin where they should, and are refused where they can't be."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from pxr import Usd

from tests.engines import ENGINES, installed
from usdphysics_conformance.stages import body, box, joint, stage
from wmspec.core.diagnostics import StageError
from wmspec.sim.scene.joints.articulations import trees
from wmspec.sim.scene.joints.coordinates import mimic_constraints
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.validate import validate
from wmspec.sim.usd import read

CUBE = box(0.1, 0.1, 0.1)


def opened(text: str, *, strict: bool = True) -> Scene:
    made = Usd.Stage.CreateInMemory()
    made.GetRootLayer().ImportFromString(text)
    return read(made, strict=strict)


def machine(*joints: str, units: str = "metersPerUnit = 1") -> str:
    bodies = [body(name, CUBE) for name in ("cart", "wheel", "third")]
    return stage(*bodies, *joints).replace("metersPerUnit = 1", units)


RAIL = joint("Prismatic", "rail", "", "cart", axis="X")


def axle(mimic: tuple[str, float, float], *, physx: bool = False) -> str:
    return joint("Revolute", "axle", "", "wheel", axis="Y", mimic=mimic, physx=physx)


@pytest.mark.parametrize("physx", [False, True])
@pytest.mark.parametrize(("units", "meters"), [("metersPerUnit = 1", 1.0), ("metersPerUnit = 0.01", 0.01)])
def test_coefficients_are_in_degrees_and_lengths_of_the_stage(physx: bool, units: str, meters: float) -> None:
    scene = opened(machine(RAIL, axle(("rail", 0.0, 90.0), physx=physx), units=units))
    (mimic,) = [j.mimic for j in scene.joints if j.mimic]
    assert mimic.leader == "rail"
    assert mimic.ratio == pytest.approx(math.pi / 2 / meters)


def test_mimic_of_a_mimic_follows_it() -> None:
    third = joint("Prismatic", "third_rail", "", "third", axis="Z", mimic=("axle", 0.0, 0.5))
    scene = opened(machine(RAIL, axle(("rail", 0.0, 90.0)), third))
    made = {j.name: j.mimic for j in scene.joints if j.mimic}
    assert made["third_rail"].leader == "rail"
    assert made["third_rail"].ratio == pytest.approx(45.0)
    assert len(trees(scene)) == 1  # an engine has them as one


def test_wrong_start_is_moved_or_refused() -> None:
    text = machine(RAIL, axle(("rail", 30.0, 1.0)))
    with pytest.raises(StageError, match=r"axle: it starts 0\.524 off its mimicked coordinate"):
        validate(opened(text))
    scene = opened(text, strict=False)
    validate(scene)
    assert [str(note) for note in scene.notes if "is moved" in note.message]
    (gear,) = mimic_constraints(scene)
    assert gear.offset == pytest.approx(math.radians(30))
    # One unit of force between the two moves the cart, 1 kg, and turns the wheel.
    (wheel,) = [b.inertia for b in scene.bodies if b.name == "wheel"]
    assert wheel
    assert gear.lightness == pytest.approx(1 / wheel.moments[1] + gear.ratio**2)


@pytest.mark.parametrize(
    ("joints", "reason"),
    [
        ((RAIL, axle(("nothing", 0, 1))), "nothing"),
        ((RAIL, axle(("axle", 0, 1))), "it mimics itself"),
        ((joint("Fixed", "rail", "", "cart"), axle(("rail", 0, 1))), "it mimics /World/rail"),
        ((RAIL, axle(("rail", 0, math.nan))), "finite"),
    ],
)
def test_impossible_mimic_joints_are_refused(joints: tuple[str, ...], reason: str) -> None:
    with pytest.raises(StageError, match=reason):
        opened(machine(*joints))


def limited(other: tuple[float, float]) -> Scene:
    falls = joint("Prismatic", "falls", "", "cart", axis="Z", limits=(-0.1, 0.04))
    at, mimic = (1.0, 0.0, 0.0), ("falls", 0.0, 1.0)
    slides = joint("Prismatic", "slides", "", "wheel", at, axis="X", limits=other, mimic=mimic)
    scene = opened(stage(body("cart", CUBE), body("wheel", CUBE, at), falls, slides))
    return replace(scene, duration=1.0, rate=240)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("other", [(-0.1, 0.04), (-0.5, 0.5), (-0.05, 0.04)])
def test_the_limits_of_either_hold_both(engine: str, other: tuple[float, float]) -> None:
    scene = limited(other)
    trace = installed(engine).execute(scene)
    cart, wheel = (trace.position[-1, trace.bodies.index(name)] for name in ("cart", "wheel"))
    assert cart[2] == pytest.approx(max(-0.1, other[0]), abs=5e-4)
    assert wheel[0] == pytest.approx(1 + max(-0.1, other[0]), abs=5e-4)


@pytest.mark.parametrize(("other", "kept"), [((-0.1, 0.04), 1), ((-0.05, 0.04), 1), ((-0.5, 0.5), 2)])
def test_sapien_drops_limits_that_a_mimic_repeats(other: tuple[float, float], kept: int) -> None:
    installed("sapien")
    from wmspec.backends.sapien.physics import prepare

    whole, _ = prepare(limited(other))
    assert sum(bool(limb.limits) for tree in whole.trees for limb in tree) == kept
