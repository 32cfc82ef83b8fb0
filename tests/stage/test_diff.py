"""The difference of two stages is exact, and does not depend on how they are written."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from tests.stage.composed import Difference, diff
from tests.stage.stages import DATA, stage

BALL = "/World/Objects/ball/ball"


def opened(name: str = "collide.usda") -> Usd.Stage:
    """A stage of the data folder."""
    return Usd.Stage.Open(str(DATA / name))


def changed(change: Callable[[Usd.Stage], object]) -> Usd.Stage:
    """The stage with a change in a layer over it."""
    above = opened()
    above.SetEditTarget(above.GetSessionLayer())
    change(above)
    return above


def set_to(path: str, value: object) -> Callable[[Usd.Stage], object]:
    """Author an attribute."""
    return lambda s: s.GetAttributeAtPath(path).Set(value)


def test_layers_do_not_matter() -> None:
    assert diff(opened(), changed(lambda s: None)) == ()
    flat = Usd.Stage.Open(changed(lambda s: None).Flatten())
    assert diff(opened(), flat) == ()


def test_an_authored_fallback_is_no_difference() -> None:
    assert diff(opened(), changed(set_to("/World/Objects/cart.physics:rigidBodyEnabled", True))) == ()


@pytest.mark.parametrize(
    ("change", "path", "before", "after"),
    [
        (set_to(f"{BALL}.radius", 0.06), f"{BALL}.radius", 0.05, 0.06),
        (set_to(f"{BALL}.physics:density", 7.0), f"{BALL}.physics:density", 0.0, 7.0),
        (set_to(f"{BALL}.radius", float("nan")), f"{BALL}.radius", 0.05, float("nan")),
        (
            set_to("/World/Episode/Observations/before.wms:times", [0.0, 1.0]),
            "/World/Episode/Observations/before.wms:times",
            (0.0, 0.25, 0.5),
            (0.0, 1.0),
        ),
        (
            lambda s: s.GetRelationshipAtPath("/World/Episode/Actions/push.wms:object").SetTargets(
                ["/World/Objects/cube"]
            ),
            "/World/Episode/Actions/push.wms:object",
            ("/World/Objects/ball",),
            ("/World/Objects/cube",),
        ),
        (lambda s: s.DefinePrim("/World/Lights/lamp", "SphereLight"), "/World/Lights/lamp", None, "SphereLight"),
        (lambda s: s.GetPrimAtPath(BALL).SetTypeName("Cylinder"), BALL, "Sphere", "Cylinder"),
        (lambda s: s.GetPrimAtPath(BALL).SetActive(False), f"{BALL}[active]", True, False),
        (lambda s: s.SetMetadata("upAxis", "Y"), "/[upAxis]", "Z", "Y"),
        (
            lambda s: UsdPhysics.ArticulationRootAPI.Apply(s.GetPrimAtPath("/World")),
            "/World[apiSchemas]",
            (),
            ("PhysicsArticulationRootAPI",),
        ),
        (
            lambda s: s.GetPrimAtPath(BALL).CreateAttribute("mark", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(1)),
            f"{BALL}.mark",
            None,
            Gf.Vec3f(1),
        ),
        (
            lambda s: s.GetPrimAtPath(BALL).CreateAttribute("mark", Sdf.ValueTypeNames.Color3f),
            f"{BALL}.mark",
            None,
            "color3f",
        ),
        (
            lambda s: s.GetAttributeAtPath(f"{BALL}.radius").Set(0.06, 1.0),
            f"{BALL}.radius[timeSamples]",
            None,
            ((1.0, 0.06),),
        ),
        (
            lambda s: s.GetAttributeAtPath("/World/Looks/red/surface.inputs:roughness").AddConnection(
                "/World/Looks/red.inputs:r"
            ),
            "/World/Looks/red/surface.inputs:roughness[connections]",
            (),
            ("/World/Looks/red.inputs:r",),
        ),
    ],
)
def test_one_change_is_one_difference(
    change: Callable[[Usd.Stage], object], path: str, before: object, after: object
) -> None:
    # by their text, since not-a-number is not equal to itself
    assert repr(diff(opened(), changed(change))) == repr((Difference(path, before, after),))
    assert repr(diff(changed(change), opened())) == repr((Difference(path, after, before),))


def test_differences_are_sorted() -> None:
    def change(s: Usd.Stage) -> None:
        for path in (f"{BALL}.radius", "/World/Cameras/front.focalLength", "/World/Episode.wms:duration"):
            set_to(path, 9.0)(s)

    paths = [d.path for d in diff(opened(), changed(change))]
    assert paths == sorted(paths)
    assert len(paths) == 3


def test_the_order_of_prims_is_a_difference() -> None:
    a, b = stage('def Cube "a" {} def Cube "b" {}'), stage('def Cube "b" {} def Cube "a" {}')
    assert diff(a, b) == (Difference("/World[order]", ("a", "b"), ("b", "a")),)


def test_interpolation_is_a_difference() -> None:
    a, b = (
        stage(f'def Cube "a" {{ color3f[] primvars:displayColor = [(1, 0, 0)] (interpolation = "{kind}") }}')
        for kind in ("constant", "uniform")
    )
    path = "/World/a.primvars:displayColor[interpolation]"
    assert diff(a, b) == (Difference(path, UsdGeom.Tokens.constant, UsdGeom.Tokens.uniform),)
