"""What a spec becomes on the stage: parts and their mass, meshes, looks, joints, cameras that ride, every verb."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image
from pxr import Usd

from tests.stage.composed import diff
from wmspec.compile.design.design import Design
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.compile.stage.write import write_stages
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir import ir
from wmspec.lang.check.ir.record import from_json, to_json
from wmspec.lang.check.statements.builder import (
    PYTHON_LOCATION,
    action,
    compound,
    factor,
    joint,
    observe,
    robot,
    task,
    thing,
)
from wmspec.sim.materials import MATERIALS
from wmspec.sim.scene.model import Follow, Force, Impulse, Launch, Scene, Steer, Teleport
from wmspec.sim.scene.model.transform import apply, rotate
from wmspec.sim.shapes import Box, Mesh
from wmspec.sim.usd import read

CAMERA = thing("camera", "front", at=(0, -2, 1))
TABLE = thing("object", "table", shape="box", size=(2, 2, 0.1), at=(0, 0, -0.05), friction=0.4, fixed=True)
BALL = thing("object", "ball", shape="sphere", size=0.1, on="table", at=(0.2, 0.1), mass=0.5, friction=0.9)
ARCH = {
    "left": {"shape": "box", "size": (0.02, 0.04, 0.08), "at": (-0.05, 0, 0.04)},
    "right": {"shape": "box", "size": (0.02, 0.04, 0.08), "at": (0.05, 0, 0.04), "material": "wood"},
    "top": {"shape": "box", "size": (0.12, 0.04, 0.02), "at": (0, 0, 0.09), "color": "red"},
}


def built(*parts: Any, change: ir.Counterfactual | None = None, index: int = 0) -> Document:
    """The document of an instance of a task of the table, a camera and these things."""
    spec = task("built", CAMERA, TABLE, *parts, observe("front", [0.0, 3.0]))
    return document(spec, Design(spec)[index], change)


def scene(*parts: Any, change: ir.Counterfactual | None = None) -> Scene:
    """The same, read back."""
    return read(compose(built(*parts, change=change)))


def deed(*parts: Any, change: ir.Counterfactual | None = None) -> Any:
    """The first action of such a scene."""
    return scene(*parts, change=change).actions[0]


# ---------------------------------------------------------------- objects


def test_compound_is_one_body_of_its_mass() -> None:
    body = scene(*compound("arch", ARCH, on="table", mass=0.4)).bodies[-1]
    assert (body.name, [g.name for g in body.geoms]) == ("arch", ["left", "right", "top"])
    assert body.inertia is not None
    assert body.inertia.mass == pytest.approx(0.4)
    np.testing.assert_allclose(body.inertia.center, (0, 0, (2 * 64 * 4 + 96 * 9) / (2 * 64 + 96) / 100), atol=1e-7)


def test_parts_look_as_their_object_where_they_do_not_say() -> None:
    geoms = scene(*compound("arch", ARCH, on="table", color="blue", roughness=0.3)).bodies[-1].geoms
    (left, right, top) = (g.surface for g in geoms)
    assert left.texture is None
    assert right.texture == str(MATERIALS["wood"].path)
    np.testing.assert_allclose(left.color, right.color, atol=1e-6)
    assert top.color[0] > 0.7
    assert {round(s.roughness, 6) for s in (left, right, top)} == {0.3}


def test_a_wedge_falls_from_left_to_right() -> None:
    shape = scene(thing("object", "ramp", shape="wedge", size=(0.4, 0.2, 0.3), on="table")).bodies[-1].geoms[0].shape
    assert isinstance(shape, Mesh)
    assert {(x, z) for x, _, z in np.round(shape.points, 6).tolist()} == {(-0.2, -0.15), (0.2, -0.15), (-0.2, 0.15)}
    solid = trimesh.Trimesh(shape.points, shape.faces)
    assert solid.is_watertight
    assert solid.volume == pytest.approx(0.012)


def test_the_top_of_a_plane_is_where_it_is_placed() -> None:
    body = scene(thing("object", "ground", shape="plane", size=(3, 2), at=(0, 0, 0.5), fixed=True)).bodies[-1]
    (geom,) = body.geoms
    assert isinstance(geom.shape, Box)
    np.testing.assert_allclose(geom.shape.half, (1.5, 1.0, 0.05))
    assert apply(body.pose, geom.pose.position)[2] + 0.05 == pytest.approx(0.5)


def test_absent_objects_have_no_prims_and_no_actions() -> None:
    parts = (
        *compound("arch", ARCH, on="table", present=False),
        action("go", "impulse", object="arch", direction=0, impulse=1),
    )
    assert not [path for path in built(*parts).prims if "arch" in path or "/go" in path]


# ---------------------------------------------------------------- meshes and images


@pytest.fixture
def cup(tmp_path: Path) -> str:
    """A ball as an OBJ file in centimetres with texture coordinates, and none of it at its origin."""
    ball = trimesh.creation.icosphere(subdivisions=2, radius=4)
    ball.apply_translation((0, 0, 10))
    ball.visual = trimesh.visual.TextureVisuals(uv=ball.vertices[:, :2] / 8 + 0.5)
    ball.export(tmp_path / "cup.obj")
    return str(tmp_path / "cup.obj")


@pytest.mark.parametrize(("collision", "lowest"), [("hull", 0.06), ("bounds", 0.06)])
def test_mesh_rests_on_its_lowest_point_for_any_origin(cup: str, collision: str, lowest: float) -> None:
    mesh = thing("object", "cup", file=cup, scale=0.01, collision=collision, on="table")
    document_ = built(mesh)
    prim = document_.prims["/World/Objects/cup/mesh"]
    assert prim.attributes["physics:approximation"].value == {"hull": "convexHull", "bounds": "boundingCube"}[collision]
    assert document_.prims["/World/Objects/cup"].attributes["xformOp:translate"].value[2] == pytest.approx(-lowest)
    shape = next(g.shape for g in read(compose(document_)).bodies[-1].geoms if g.visible)
    assert isinstance(shape, Mesh)
    assert shape.st is not None
    np.testing.assert_allclose(shape.st, shape.points[:, :2] / 0.08 + 0.5, atol=1e-5)


def test_a_turned_mesh_in_its_box_rests_on_the_box(cup: str) -> None:
    boxed = thing("object", "cup", file=cup, scale=0.01, collision="bounds", on="table", roll=math.pi / 4)
    z = built(boxed).prims["/World/Objects/cup"].attributes["xformOp:translate"].value[2]
    assert z == pytest.approx(-(0.06 - 0.04) * math.sqrt(0.5), abs=1e-4)  # its lowest corner is at (0, 4, 6) cm


@pytest.mark.parametrize(
    ("name", "content"), [("a.obj", "nothing"), ("a.stl", "solid"), ("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3")]
)
def test_a_broken_or_flat_mesh_is_refused(tmp_path: Path, name: str, content: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(WmsError, match=r"<python>:1:1: .*(broken|volume)"):
        built(thing("object", "a", file=str(tmp_path / name), on="table"))


def test_a_picture_keeps_its_colours_and_a_pattern_takes_that_of_the_object(tmp_path: Path) -> None:
    Image.new("RGB", (4, 4), "red").save(tmp_path / "face.png")
    found = scene(
        thing("object", "faced", on="table", image=str(tmp_path / "face.png")),
        thing("object", "grained", on="table", material="wood", color="blue"),
        thing("object", "wooden", on="table", material="wood"),
    )
    faced, grained, wooden = (b.geoms[0].surface for b in found.bodies[1:])
    assert (faced.texture, faced.repeats) == (str(tmp_path / "face.png"), None)
    np.testing.assert_allclose(faced.color, (1, 1, 1), atol=1e-6)
    assert grained.repeats == pytest.approx((MATERIALS["wood"].repeats,) * 2)
    assert grained.color[2] > 0.7
    np.testing.assert_allclose(wooden.color, MATERIALS["wood"].color, atol=1e-6)
    assert wooden.roughness == pytest.approx(MATERIALS["wood"].roughness)


def test_written_stages_take_their_images_along(tmp_path: Path) -> None:
    spec = task("t", CAMERA, TABLE, factor("m", ["wood", "plastic"]), observe("front", [0]),
                thing("object", "a", on="table", material=ir.Ref(name="m")))  # fmt: skip
    design = Design(spec)
    for out in ("one", "two"):
        (tmp_path / out).mkdir()
        write_stages(design, design[1], tmp_path / out)
    files = [{f.name: f.read_bytes() for f in sorted((tmp_path / out).rglob("*.*"))} for out in ("one", "two")]
    assert files[0] == files[1]
    (tmp_path / "one").rename(tmp_path / "elsewhere")
    base, over = (Usd.Stage.Open(str(tmp_path / "elsewhere" / f"{name}.usda")) for name in ("base", "000001"))
    assert Path(read(base).bodies[-1].geoms[0].surface.texture or "").parent == tmp_path / "elsewhere" / "textures"
    assert read(over).bodies[-1].geoms[0].surface.texture is None
    assert [d.path for d in diff(over, compose(document(spec, design[1]))) if d.after is not None] == []


# ---------------------------------------------------------------- joints and cameras

DOOR = thing("object", "door", shape="box", size=(0.4, 0.02, 0.6), at=(0.2, 0, 0.5), yaw=0.3)
POST = thing("object", "post", shape="box", size=(0.02, 0.02, 1), at=(0, 0, 0.5), yaw=-1.0, fixed=True)


def test_both_frames_of_a_joint_are_where_it_is_and_along_its_axis() -> None:
    hinge = joint("swing", "hinge", of="door", to="post", at=(0, 0.1, 0.7), axis=(0, 3, 4), low=-0.5, high=1.5)
    found = scene(POST, DOOR, hinge)
    (swing,) = found.joints
    assert (swing.kind, swing.first, swing.second) == ("hinge", "post", "door")
    assert swing.limits == pytest.approx((-0.5, 1.5))
    for name, frame in ((swing.first, swing.first_frame), (swing.second, swing.second_frame)):
        body = next(b for b in found.bodies if b.name == name)
        np.testing.assert_allclose(apply(body.pose, frame.position), (0, 0.1, 0.7), atol=1e-6)
        axis = rotate(body.pose.orientation, rotate(frame.orientation, np.array([1.0, 0.0, 0.0])))
        np.testing.assert_allclose(axis, (0, 0.6, 0.8), atol=1e-6)


def test_a_drive_is_in_radians_and_an_action_changes_its_target() -> None:
    hinge = joint("swing", "hinge", of="door", at=(0, 0, 0.5), target=1.0, stiffness=2.0, damping=0.5)
    found = scene(DOOR, hinge, action("shut", "drive", joint="swing", target=0.25, start=0.5))
    drive = found.joints[0].drive
    assert drive is not None
    assert (drive.stiffness, drive.damping, drive.target) == pytest.approx((2.0, 0.5, 1.0))
    assert isinstance(found.actions[0], Steer)
    assert (found.actions[0].joint, found.actions[0].target) == ("swing", 0.25)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ((POST, joint("j", "hinge", of="post", at=(0, 0, 0))), "`post` is fixed, so no joint can move it"),
        ((DOOR, joint("j", "hinge", of="door", to="door", at=(0, 0, 0))), "joins `door` to itself"),
        ((DOOR, joint("j", "hinge", of="door", at=(0, 0, 0), axis=(0, 0, 0))), "has no axis"),
        ((DOOR, joint("j", "hinge", of="door", at=(0, 0, 0), low=1, high=0)), "`low` of `j` is above its `high`"),
        ((DOOR, joint("j", "hinge", of="door", at=(0, 0, 0), target=1, stiffness=0)), "its stiffness is 0"),
        ((DOOR, joint("j", "hinge", of="door", at=(0, 0, 0)),
          action("a", "launch", object="door", direction=0, speed=1)), "a joint holds `door`"),
        ((DOOR, joint("j", "hinge", of="door", at=(0, 0, 0)),
          action("a", "teleport", object="door", to=(1, 0, 1))), "a joint holds `door`"),
        ((POST, DOOR, joint("j", "hinge", of="door", to="post", at=(0, 0, 0)),
          action("a", "glide", object="door", direction=0, speed=1, duration=1)), "`door` is carried by `a`"),
        ((BALL, DOOR, joint("j", "hinge", of="door", to="ball", at=(0, 0, 0)),
          action("a", "glide", object="ball", direction=0, speed=1, duration=1)), "`ball` is carried by `a`"),
        ((DOOR, joint("j", "hinge", of="door", at=(0, 0, 0), low=0.1)), "beyond its limit of 5.7"),
        ((DOOR, joint("j", "slider", of="door", at=(0, 0, 0), high=-0.1)), "beyond its limit of -10 cm"),
        ((BALL, DOOR, joint("j", "hinge", of="door", to="ball", at=(0, 0, 0)),
          joint("k", "ball", of="ball", to="door", at=(0, 0, 0))), "`k` joins `ball` and `door`, which other joints"),
        ((POST, BALL, DOOR, joint("j", "hinge", of="door", to="ball", at=(0, 0, 0)),
          joint("k", "ball", of="ball", to="post", at=(0, 0, 0)), joint("l", "fixed", of="door", at=(0, 0, 0))),
         "`l` holds `door` to the world"),
        ((DOOR, joint("j", "hinge", of="door", at=(0, 0, 0)), action("a", "drive", joint="j", target=1)),
         "has no drive"),
        ((a := robot("car", "car"), BALL, action("g", "forward", by=a, distance=1, duration=1)),
         "`car` cannot forward so: it has no roads"),
        ((a := robot("arm", "panda"), BALL, action("g", "pick", by=a, object="ball", height=0.1, duration=1)),
         "`ball` is 10 cm wide, and `arm` takes what is less than 8 cm"),
        ((a := robot("arm", "panda"), action("g", "pick", by=a, object="table", height=0.1, duration=1)),
         "`table` is fixed, so no robot can move it"),
        ((BALL, action("a", "glide", object="ball", direction=0, speed=1, duration=1),
          action("b", "launch", object="ball", direction=0, speed=1)), "`ball` is carried by `a`"),
        ((action("a", "impulse", object="table", direction=0, impulse=1),), "`table` is fixed"),
        ((BALL, action("a", "release", object="ball", start=1), action("b", "drop", object="ball", height=1)),
         "let go more than once"),
        ((DOOR, action("a", "slide", object="door", direction=0, distance=1)), "rests on nothing"),
        ((BALL, action("a", "follow", object="ball", path=[(0.0, 0.0)], duration=1)), "leads nowhere"),
        ((thing("object", "gone", present=False), thing("camera", "eye", at=(0, 0, 1), ride="gone")),
         "which is not there"),
    ],
)  # fmt: skip
def test_nonsense_is_refused_at_its_place(parts: tuple[Any, ...], message: str) -> None:
    with pytest.raises(WmsError, match=rf"^<python>:1:1: .*{message}"):
        built(*parts)


def test_a_camera_rides_in_the_frame_of_its_object() -> None:
    eye = thing("camera", "eye", at=(0, 0, 0.2), look_at=(1, 0, 0.2), ride="ball")
    camera = next(c for c in scene(BALL, eye).cameras if c.name == "eye")
    assert camera.body == "ball"
    np.testing.assert_allclose(camera.pose.position, (0, 0, 0.2), atol=1e-7)
    np.testing.assert_allclose(rotate(camera.pose.orientation, np.array([0.0, 0.0, -1.0])), (1, 0, 0), atol=1e-7)


# ---------------------------------------------------------------- verbs


def test_direction_words_and_climb_aim_a_launch() -> None:
    launch = deed(BALL, action("go", "launch", object="ball", direction="left", speed=2, climb=math.pi / 6))
    assert isinstance(launch, Launch)
    np.testing.assert_allclose(launch.linear, (-math.sqrt(3), 0, 1), atol=1e-12)


def test_impulses_and_forces_keep_their_size_and_direction() -> None:
    struck = deed(BALL, action("go", "impulse", object="ball", direction="away", impulse=0.3))
    assert isinstance(struck, Impulse)
    np.testing.assert_allclose(struck.impulse, (0, 0.3, 0), atol=1e-12)
    pulled = deed(BALL, action("go", "force", object="ball", direction="nearer", force=2, start=0.5, duration=1))
    assert isinstance(pulled, Force)
    np.testing.assert_allclose(pulled.force, (0, -2, 0), atol=1e-12)
    assert (pulled.start, pulled.stop) == (0.5, 1.5)


def test_sliding_starts_at_the_friction_limit() -> None:
    block = thing("object", "block", shape="cube", size=0.1, on="table", at=(0.2, 0.1), friction=0.9)
    slide = deed(block, action("go", "slide", object="block", direction="right", distance=0.5))
    assert isinstance(slide, Launch)
    mu = math.sqrt(0.4 * 0.9)
    np.testing.assert_allclose(slide.linear, (math.sqrt(2 * mu * 9.81 * 0.5), 0, 0), atol=1e-12)


@pytest.mark.parametrize(
    ("form", "direction", "rolls"),
    [
        ({"shape": "sphere"}, "left", True),
        ({"shape": "sphere", "pitch": 1.0}, "left", True),
        ({"shape": "cylinder"}, "left", False),
        ({"shape": "cylinder", "pitch": math.pi / 2}, "left", False),
        ({"shape": "cylinder", "pitch": math.pi / 2}, "away", True),
        ({"shape": "capsule", "roll": math.pi / 2, "yaw": 0.5}, 0.5, True),
        ({"shape": "capsule", "roll": math.pi / 2, "yaw": 0.5}, 0.5 - math.pi / 2, False),
        ({"shape": "cone"}, "left", False),
        ({"shape": "box", "pitch": math.pi / 2}, "away", False),
    ],
)
def test_round_contact_rolls_and_does_not_slide(form: Any, direction: Any, rolls: bool) -> None:
    parts = (
        thing("object", "it", size=0.1, on="table", **form),
        action("go", "slide", object="it", direction=direction, distance=0.5),
    )
    if not rolls:
        assert isinstance(deed(*parts), Launch)
        return
    with pytest.raises(WmsError, match="`it` is round and would roll on"):
        built(*parts)


@pytest.mark.parametrize(
    ("path", "end", "length"),
    [
        ("straight", (0.4, 0), 0.4),
        ("arc", (0.4, 0), 2 * 0.25 * math.asin(0.8)),
        ("zigzag", (0.4, 0), 4 * math.hypot(0.1, 0.1)),
        ("circle", (0, 0), math.pi * 0.4),
        ("back_and_forth", (0, 0), 0.8),
        ([(0.1, 0.0), (0.1, 0.2)], (0.1, 0.2), 0.3),
    ],
)
def test_paths_end_at_their_goal_at_constant_speed(path: Any, end: tuple[float, float], length: float) -> None:
    follow = deed(
        BALL, action("go", "follow", object="ball", path=path, direction="away", length=0.4, width=0.1, duration=2)
    )
    assert isinstance(follow, Follow)
    steps, times = np.linalg.norm(np.diff(follow.points, axis=0), axis=1), np.diff(follow.times)
    np.testing.assert_allclose(steps / times, length / 2, rtol=1e-3)
    assert follow.times[-1] == pytest.approx(2)
    start = np.array([0.2, 0.1, 0.05])
    np.testing.assert_allclose(follow.points[0], start)
    np.testing.assert_allclose(follow.points[-1], start + np.array([-end[1], end[0], 0]), atol=1e-12)
    if path == "arc":
        assert (start - follow.points)[:, 0].max() == pytest.approx(0.1, rel=1e-3)


def test_each_way_begins_where_the_last_one_ended() -> None:
    deeds = scene(
        BALL,
        action("one", "glide", object="ball", direction="right", speed=0.2, duration=1),
        action("two", "follow", object="ball", path="straight", direction="away", length=0.3, duration=1, start=1),
        action("three", "teleport", object="ball", to=(-0.5, 0.5), yaw=1.0, start=2),
        action("four", "follow", object="ball", path="circle", length=0.2, duration=0.5, start=2.2),
    ).actions
    two, three, four = deeds[1], deeds[2], deeds[3]
    assert isinstance(two, Follow)
    assert isinstance(three, Teleport)
    assert isinstance(four, Follow)
    np.testing.assert_allclose(two.points[[0, -1]], [(0.4, 0.1, 0.05), (0.4, 0.4, 0.05)], atol=1e-12)
    np.testing.assert_allclose(three.position, (-0.5, 0.5, 0.05))
    np.testing.assert_allclose(four.points[0], three.position)


def test_teleported_solid_body_is_free() -> None:
    jump = action("a", "teleport", object="ball", to=(1, 0))
    made = scene(BALL, jump)
    (ball,) = (body for body in made.bodies if body.name == "ball")
    assert ball.motion == "dynamic"
    assert isinstance(made.actions[0], Teleport)
    assert made.actions[0].orientation is None, "it keeps the one it has then"
    turned = scene(BALL, action("a", "teleport", object="ball", to=(1, 0), yaw=0.0)).actions[0]
    assert isinstance(turned, Teleport)
    assert turned.orientation is not None
    mark = thing("object", "ball", shape="sphere", size=0.1, at=(0.2, 0.1, 0.05), solid=False)
    assert [body.motion for body in scene(mark, jump).bodies if body.name == "ball"] == ["kinematic"]


def test_actions_whose_order_is_changed_exchange_their_turns() -> None:
    first = action("first", "force", object="ball", direction=0, force=1, start=0.2, duration=1.0)
    then = action("then", "force", object="ball", direction=1, force=1, start=1.5, duration=0.4)
    later = action(
        "later",
        "impulse",
        object="ball",
        direction=1,
        impulse=1,
        start=ir.Property(owner=ir.Value(value="then"), name="start"),
    )
    swap = ir.Counterfactual(
        name="s", change="order", owner="then", property="first", value=None, sort="", place=PYTHON_LOCATION
    )
    starts = {a.name: a.start for a in scene(BALL, first, then, later, change=swap).actions}
    assert starts == pytest.approx({"first": 0.9, "then": 0.2, "later": 1.5})  # the pause of 0.3 s stays, and the end


def test_the_document_of_a_spec_that_went_through_json_is_the_same(cup: str) -> None:
    spec = task(
        "t", CAMERA, TABLE, *compound("arch", ARCH, on="table"), thing("object", "c", file=cup), observe("front", [0])
    )
    again = from_json(to_json(spec))
    assert document(again, Design(again)[0]).differing(document(spec, Design(spec)[0])) == {}
