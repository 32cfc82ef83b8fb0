"""Jointed bodies begin as joints let them: with their momentum along every way that the joints leave free."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Usd

from usdphysics_conformance import all_cases
from wmspec.core.diagnostics import StageError
from wmspec.sim.scene.joints.articulations import trees
from wmspec.sim.scene.joints.com_frame import com_frame
from wmspec.sim.scene.joints.coordinates import coordinates
from wmspec.sim.scene.joints.momentum import inconsistent_velocities, project_velocities
from wmspec.sim.scene.model import Array, Scene
from wmspec.sim.scene.model.transform import apply
from wmspec.sim.scene.validate import validate
from wmspec.sim.usd import read

MECHANISMS = ("double_pendulum", "four_bar", "nunchaku_thrown", "pendulum_conical", "mimic_hoist", "dumbbell_thrown")
NUMBERS = st.floats(-5, 5).map(lambda x: round(x, 3))


@cache
def mechanism(name: str) -> Scene:
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().ImportFromString(all_cases()[name].stage)
    return replace(read(stage, strict=False), duration=0.1)


def scene_of(name: str, speeds: list[float]) -> Scene:
    scene = mechanism(name)
    each = np.resize(np.array(speeds), (len(scene.bodies), 6))
    dynamic = [body.motion == "dynamic" for body in scene.bodies]
    bodies = [
        replace(b, linear_velocity=v[:3], angular_velocity=v[3:]) if moves else b
        for b, v, moves in zip(scene.bodies, each, dynamic, strict=True)
    ]
    return replace(scene, bodies=tuple(bodies))


def whole(scene: Scene) -> Array:
    return np.concatenate([[*b.linear_velocity, *b.angular_velocity] for b in scene.bodies if b.motion == "dynamic"])


@pytest.mark.parametrize("name", MECHANISMS)
@settings(max_examples=6, deadline=None)
@given(speeds=st.lists(NUMBERS, min_size=7, max_size=18))
def test_the_nearest_velocities_that_fit(name: str, speeds: list[float]) -> None:
    given_ = scene_of(name, speeds)
    begun, _ = project_velocities(given_)
    validate(begun)
    assert not list(inconsistent_velocities(begun))
    again, reported = project_velocities(begun)
    assert not reported
    np.testing.assert_allclose(whole(again), whole(begun), atol=1e-8)
    every = coordinates(given_)  # what joints take away, they take across the ways that they leave free
    order = [
        [b.name for b in given_.bodies if b.motion == "dynamic"].index(given_.bodies[i].name) for i in every.bodies
    ]
    lost = (whole(given_) - whole(begun)).reshape(-1, 6)[order].ravel()
    if name not in ("four_bar", "mimic_hoist"):  # where points and mimics hold too
        np.testing.assert_allclose(every.ways @ every.masses @ lost, 0, atol=1e-8)
    energies = [v @ every.masses @ v for v in (w.reshape(-1, 6)[order].ravel() for w in map(whole, (begun, given_)))]
    assert energies[0] <= energies[1] + 1e-9


@pytest.mark.parametrize("name", MECHANISMS)
@settings(max_examples=4, deadline=None)
@given(speeds=st.lists(NUMBERS, min_size=7, max_size=18))
def test_joints_keep_their_points_together(name: str, speeds: list[float]) -> None:
    scene, _ = project_velocities(scene_of(name, speeds))
    bodies = {body.name: body for body in scene.bodies}
    for joint in scene.joints:
        if joint.kind == "slider":
            continue
        frame, speed = [], []
        for end, local in ((joint.first, joint.first_frame), (joint.second, joint.second_frame)):
            body = bodies[end] if end else None
            at = local.position if body is None else apply(body.pose, local.position)
            frame.append(at)
            arm = np.zeros(3) if body is None else at - com_frame(body).pose.position
            speed.append(np.zeros(3) if body is None else body.linear_velocity + np.cross(body.angular_velocity, arm))
        np.testing.assert_allclose(speed[0], speed[1], atol=1e-6)  # places in joints have 32 bits


def test_the_strict_refuse_what_does_not_fit() -> None:
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().ImportFromString(all_cases()["pendulum_jerked"].stage)
    with pytest.raises(StageError, match=r"violate its joints, which allow \(1\.429, 0, 0\) m/s"):
        validate(read(stage))
    assert any("it is corrected" in note.message for note in read(stage, strict=False).notes)


def test_resting_bodies_have_no_rates() -> None:
    assert all(link.rate == () for tree in trees(mechanism("double_pendulum")) for link in tree)
