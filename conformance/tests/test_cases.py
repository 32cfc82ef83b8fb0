"""The cases are plain USD, and their answers are those of mechanics."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, UsdPhysics

from usdphysics_conformance import ConformanceError, all_cases, select_cases
from usdphysics_conformance.quaternions import multiply, rotate, rotation_vector
from usdphysics_conformance.reference import DOUBLE_PENDULUM_END, DZHANIBEKOV_TIME, elliptic_k

Array = NDArray[np.float64]
CASES = all_cases()


def test_there_are_many_and_each_criterion_names_its_source() -> None:
    assert len(CASES) == 74
    criteria = [criterion for case in CASES.values() for criterion in case.criteria]
    assert len(criteria) == 109
    for case in CASES.values():
        assert len({c.description for c in case.criteria}) == len(case.criteria)
    assert all(c.source and c.formula and c.tolerance >= 0 and math.isfinite(c.answer) for c in criteria)


@pytest.mark.parametrize("name", CASES)
def test_a_stage_is_plain_usd_with_rigid_bodies_in_one_scene(name: str) -> None:
    stage = Usd.Stage.CreateInMemory()
    assert stage.GetRootLayer().ImportFromString(CASES[name].stage)
    assert stage.GetDefaultPrim()
    prims = list(stage.Traverse())
    assert [prim.GetTypeName() for prim in prims].count("PhysicsScene") == 1
    for path in CASES[name].bodies.values():
        body = UsdPhysics.RigidBodyAPI(stage.GetPrimAtPath(path))
        assert body.GetVelocityAttr().HasAuthoredValue()
    for prim in prims:
        assert prim.IsA(UsdGeom.Imageable) or prim.GetTypeName().startswith(("Physics", "Material"))
        if prim.IsA(UsdPhysics.Joint):
            joint = UsdPhysics.Joint(prim)
            targets = joint.GetBody0Rel().GetTargets() + joint.GetBody1Rel().GetTargets()
            assert targets
            assert all(stage.GetPrimAtPath(target).IsValid() for target in targets)


def test_cases_are_selected_by_name() -> None:
    assert [case.name for case in select_cases(["spin", "free_fall", "spin"])] == ["spin", "free_fall"]
    assert len(select_cases()) == len(CASES)
    with pytest.raises(ConformanceError, match="did you mean `free_fall`"):
        select_cases(["freefall"])
    with pytest.raises(ConformanceError, match="usdphysics-conformance list"):
        select_cases(["zzz"])


# ------------------------------------------------------------------ answers that are stored or integrated


def integrate(rates: Callable[[Array], Array], state: Array, seconds: float, steps: int) -> Array:
    """The state after a time (s), by the classical Runge-Kutta method."""
    h = seconds / steps
    for _ in range(steps):
        a = rates(state)
        b = rates(state + h / 2 * a)
        c = rates(state + h / 2 * b)
        state = state + h / 6 * (a + 2 * b + 2 * c + rates(state + h * c))
    return state


def test_the_time_of_the_dzhanibekov_effect_is_that_of_eulers_equations() -> None:
    a, b, c = 0.01, 0.02, 0.028

    def rates(state: Array) -> Array:
        p, q, r = state[:3].tolist()
        turn = multiply(state[3:], (0.0, p, q, r)) / 2
        return np.array([(b - c) * q * r / a, (c - a) * r * p / b, (a - b) * p * q / c, *turn])

    start = np.array([0.02, 8.0, 0.02, 1.0, 0.0, 0.0, 0.0])
    before, after = (
        float(rotate(integrate(rates, start, DZHANIBEKOV_TIME + dt, 4000)[3:], (0.0, 1.0, 0.0))[1])
        for dt in (-1e-6, 1e-6)
    )
    assert before > 0 > after


def test_the_end_of_the_double_pendulum_is_that_of_lagranges_equations() -> None:
    arm, half, inertia, g = 0.5, 0.25, 0.01, 9.81

    def rates(state: Array) -> Array:
        a, b, u, v = state.tolist()
        mixed, turn = arm * half * math.cos(a - b), arm * half * math.sin(a - b)
        mass = [[inertia + half**2 + arm**2, mixed], [mixed, inertia + half**2]]
        force = [-turn * v * v + g * (half + arm) * math.cos(a), turn * u * u + g * half * math.cos(b)]
        return np.array([u, v, *np.linalg.solve(mass, force)])

    a, b = integrate(rates, np.zeros(4), 1.0, 4000)[:2].tolist()
    end = arm * math.cos(a) + half * math.cos(b), 0.0, -arm * math.sin(a) - half * math.sin(b)
    assert end == pytest.approx(DOUBLE_PENDULUM_END, abs=1e-8)


@pytest.mark.parametrize("m", [0.0, 0.0076, 0.25, 0.5, 0.933])
def test_the_elliptic_integral_is_that_of_its_definition(m: float) -> None:
    angle = (np.arange(2000) + 0.5) * (math.pi / 2 / 2000)  # periodic: the midpoint rule converges geometrically
    assert elliptic_k(m) == pytest.approx(np.mean(1 / np.sqrt(1 - m * np.sin(angle) ** 2)) * math.pi / 2, rel=1e-13)


def test_quaternions_rotate_as_rotations_do() -> None:
    half = math.radians(30)
    about_z = (math.cos(half), 0.0, 0.0, math.sin(half))
    assert rotate(about_z, (1.0, 0.0, 0.0)) == pytest.approx([0.5, math.sqrt(0.75), 0.0])
    assert rotation_vector(about_z, multiply(about_z, about_z)) == pytest.approx([0, 0, math.radians(60)])
    assert rotation_vector(about_z, [-x for x in about_z]) == pytest.approx([0, 0, 0], abs=1e-12)
