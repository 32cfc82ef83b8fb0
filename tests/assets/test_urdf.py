"""What wmspec makes of a URDF, against what MuJoCo's own URDF reader makes of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.assets.specs import checked, here, named, scene, spec, tensor
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.model.transform import rotation

ARM = """object arm {{
  file: "arm.urdf"  at: (0, 0, 0)  fixed: {0}
  part turn {{ start: {1} rad }}
  part rail {{ start: {2} m }}
}}"""
LINKS = {"shoulder": "arm_shoulder", "slide": "arm_slide", "tip": "arm_tip"}


@pytest.mark.parametrize(("turn", "rail"), [(0.0, 0.05), (0.7, 0.2), (-1.9, 0.3)])
def test_links_are_placed_as_in_mujoco(tmp_path: Path, turn: float, rail: float) -> None:
    folder = here(tmp_path)
    found = scene(spec(ARM.format("true", turn, rail), folder))
    model, data = in_mujoco(folder / "arm.urdf", (turn, rail))
    for link, name in LINKS.items():
        body, there = named(found, name), model.body(link).id
        np.testing.assert_allclose(body.pose.position, data.xpos[there], atol=1e-9)
        np.testing.assert_allclose(rotation(body.pose.orientation), data.xmat[there].reshape(3, 3), atol=1e-9)


def test_masses_are_those_of_mujoco(tmp_path: Path) -> None:
    folder = here(tmp_path)
    found = scene(spec(ARM.format("false", 0, 0.1), folder))
    model, data = in_mujoco(folder / "arm.urdf", (0.0, 0.1))
    for link, name in {**LINKS, "base-link": "arm"}.items():
        body, there = named(found, name), model.body(link).id
        assert body.inertia is not None
        assert body.inertia.mass == pytest.approx(model.body_mass[there], rel=1e-6)
        own, axes = rotation(body.pose.orientation), data.ximat[there].reshape(3, 3)
        np.testing.assert_allclose(body.pose.position + own @ body.inertia.center, data.xipos[there], atol=1e-6)
        theirs = axes @ np.diag(model.body_inertia[there]) @ axes.T
        np.testing.assert_allclose(own @ tensor(body) @ own.T, theirs, atol=1e-6)


def in_mujoco(path: Path, joints: tuple[float, float]) -> tuple[Any, Any]:
    """The model that MuJoCo reads, with its joints at these places; its meshes are not needed."""
    mujoco = pytest.importorskip("mujoco")
    text = path.read_text()
    begin, end = text.index('<visual><origin xyz="0.1'), text.index("</visual>") + len("</visual>")
    made = mujoco.MjSpec.from_string(text[:begin] + text[end:])
    made.compiler.fusestatic = False
    made.compiler.discardvisual = False
    model = made.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = joints
    mujoco.mj_forward(model, data)
    return model, data


def test_massless_frames_are_left_out(tmp_path: Path) -> None:
    task = spec(ARM.format("true", 0, 0.1), here(tmp_path))
    assert {t.name for t in task.things if t.kind == "object"} == {"arm", *LINKS.values()}
    assert {t.name: t.model for t in task.things if t.kind == "joint"} == {
        "arm_turn": "hinge",
        "arm_rail": "slider",
        "arm_glue": "fixed",
    }


def test_joints_are_what_the_file_says(tmp_path: Path) -> None:
    found = scene(spec(ARM.format("true", 0.5, 0.1), here(tmp_path)))
    joints = {j.name: j for j in found.joints}
    assert joints["arm_turn"].limits == pytest.approx((-2, 2))
    assert joints["arm_rail"].limits == pytest.approx((0.05, 0.3))
    drive = joints["arm_rail"].drive
    assert drive is not None
    assert (drive.stiffness, drive.damping) == (0, pytest.approx(2))


def test_a_joint_starts_at_its_limit_if_it_cannot_start_at_0(tmp_path: Path) -> None:
    task = spec('object arm { file: "arm.urdf"  at: (0, 0, 0)  fixed: true }', here(tmp_path))
    assert [t for t in task.things if "start" in t.properties] == [task.thing("arm_rail")]
    same = spec(ARM.format("true", 0, 0.05), here(tmp_path))
    for name in LINKS.values():
        np.testing.assert_allclose(poses(scene(task), name), poses(scene(same), name), atol=1e-12)


def poses(found: Scene, name: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.concatenate([named(found, name).pose.position, named(found, name).pose.orientation])


def test_visual_and_collision_geoms_differ(tmp_path: Path) -> None:
    found = scene(spec(ARM.format("true", 0, 0.1), here(tmp_path)))
    assert [(type(g.shape).__name__, g.collides, g.visible) for g in named(found, "arm_shoulder").geoms] == [
        ("Mesh", False, True),
        ("Capsule", True, False),
    ]
    assert [(g.collides, g.visible) for g in named(found, "arm_slide").geoms] == [(True, True)]
    assert [(g.collides, g.visible) for g in named(found, "arm_tip").geoms] == [(False, True)]


def test_the_whole_is_placed_and_turned_as_one(tmp_path: Path) -> None:
    ground = "object ground { shape: box  size: (4 m, 4 m, 20 cm)  at: (0, 0, -10 cm)  fixed: true }\n"
    stands = 'object cabinet { file: "cabinet.urdf"  on: ground at (1 m, 0)  yaw: 90 deg }'
    found = scene(spec(ground + stands, here(tmp_path)))
    assert named(found, "cabinet").pose.position == pytest.approx((1, 0, 0), abs=1e-12)
    assert named(found, "cabinet_door").pose.position == pytest.approx((1.19, -0.23, 0.18))
    assert named(found, "cabinet_drawer").pose.position == pytest.approx((1, 0, 0.47))


def test_lowest_part_rests(tmp_path: Path) -> None:
    """The arm's base is not its lowest part when the arm is turned over."""
    found = scene(spec('object arm { file: "arm.urdf"  at: (0, 0)  roll: 180 deg  fixed: true }', here(tmp_path)))
    assert named(found, "arm").pose.position[2] > 0.3


@pytest.mark.parametrize(
    ("said", "link", "expected"),
    [
        ("part door { mass: 6 kg }", "cabinet_door", (6, 3 * 0.019)),
        ("part door { density: 500 kg/m^3 }", "cabinet_door", (500 * 0.45 * 0.02 * 0.31, None)),
        ("density: 100 kg/m^3", "cabinet_drawer", (100 * 0.44 * 0.34 * 0.18, None)),
    ],
)
def test_spec_may_override_the_mass(tmp_path: Path, said: str, link: str, expected: tuple[float, float | None]) -> None:
    """The moments of a file go with its mass; by density they are those of the form."""
    found = scene(spec(f'object cabinet {{ file: "cabinet.urdf"  at: (0, 0, 0)  {said} }}', here(tmp_path)))
    inertia = named(found, link).inertia
    assert inertia is not None
    assert inertia.mass == pytest.approx(expected[0], rel=1e-6)
    if expected[1] is not None:
        assert tensor(named(found, link))[0, 0] == pytest.approx(expected[1], rel=1e-5)


def test_looks_of_the_file_of_the_whole_and_of_a_link(tmp_path: Path) -> None:
    def colors(said: str) -> dict[str, set[tuple[float, ...]]]:
        found = scene(spec(f'object cabinet {{ file: "cabinet.urdf"  at: (0, 0, 0)  {said} }}', here(tmp_path)))
        return {b.name: {tuple(np.round(g.surface.color, 3)) for g in b.geoms} for b in found.bodies}

    of_file, of_link, of_whole = colors(""), colors("part door { color: red }"), colors("color: red")
    assert len(of_file["cabinet_door"]) == 2
    assert of_link["cabinet"] == of_file["cabinet"]
    assert len(of_link["cabinet_door"]) == 1
    assert set.union(*of_whole.values()) == of_link["cabinet_door"]


def test_sets_of_assets(tmp_path: Path) -> None:
    body = 'objects rows[2] { file: "cabinet.urdf"  at: (index * 1 m, 0, 0) }\nlet which = rows[1].door.mass'
    task = spec(body, here(tmp_path))
    assert named(scene(task), "rows_1_door").pose.position[0] == pytest.approx(1 - 0.23)


def test_duplicate_and_missing_names(tmp_path: Path) -> None:
    path = here(tmp_path) / "spec.wms"
    path.write_text("""task t : custom {
      object cabinet { file: "cabinet.urdf"  part dor { color: red }  part hinge { at: (0, 0, 0) } }
      object cabinet_door { at: (0, 0, 0) }
      let mass = cabinet.drawr.mass
    }""")
    reported = {(d.code, getattr(d.place, "text", ""), d.help) for d in checked(path)[1].diagnostics}
    assert ("WMS201", "dor", "did you mean `door`?") in reported
    assert ("WMS203", "drawr", "did you mean `drawer`?") in reported
    assert {(code, text) for code, text, _ in reported} >= {("WMS203", "at"), ("WMS202", "cabinet")}
