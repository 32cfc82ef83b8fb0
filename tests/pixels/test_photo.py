"""The photo look: paths of light, the same bytes every time; masks and distances those of the parity look."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from tests.endtoend.test_commands import SPEED
from tests.engines import installed
from tests.pixels.scenes import body, scene
from wmspec.api import generate
from wmspec.api.generating import plan_dataset
from wmspec.api.verifying import verify
from wmspec.cli import main
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.engines.registry import require_look
from wmspec.sim.materials import TEXTURES
from wmspec.sim.photo import library
from wmspec.sim.photo.light import ceiling_lights, directions, environment_map
from wmspec.sim.scene.model import Camera, Frame, Light, Scene, Shot, Surface
from wmspec.sim.scene.render.camera import look_at, project, world_camera
from wmspec.sim.scene.render.color import to_linear
from wmspec.sim.shapes import Box, Cylinder, Sphere

SIZE, SAMPLES = 48, 4
COLORS = {"floor": (0.7, 0.7, 0.7), "red": (0.8, 0.1, 0.1), "blue": (0.1, 0.2, 0.8), "green": (0.1, 0.6, 0.2)}


def things() -> Scene:
    """A ball, a cube and a can on a floor."""
    floor = body("floor", "static", (0, 0, -0.05), Box((3.0, 3.0, 0.05)), Surface(COLORS["floor"]))
    ball = body("red", "dynamic", (-0.14, 0, 0.08), Sphere(0.08), Surface(COLORS["red"]))
    cube = body("blue", "dynamic", (0.12, 0.05, 0.07), Box((0.07,) * 3), Surface(COLORS["blue"]))
    can = body("green", "dynamic", (0, -0.15, 0.05), Cylinder(0.05, 0.1), Surface(COLORS["green"]))
    eye = Camera("eye", look_at((0, -0.9, 0.6), (0, 0, 0.05)), math.radians(34), 0.05, 10.0)
    return scene(floor, ball, cube, can, cameras=(eye,))


def drawn(what: Scene, engine: str = "mujoco", look: Any = "photo", size: int = SIZE) -> Frame:
    installed(engine)
    studio = RenderCache(engine, size, size, look, SAMPLES if look == "photo" else None)
    frame = studio.draw(what, shot(what), depth=True)
    studio.close()
    return frame


def shot(what: Scene) -> Shot:
    return Shot("eye", tuple(one.pose for one in what.bodies))


@pytest.fixture(scope="module")
def photo() -> Frame:
    pytest.importorskip("mitsuba_oidn")
    return drawn(things())


def test_masks_and_distances_are_those_of_the_parity_look(photo: Frame) -> None:
    parity = drawn(things(), look="parity")
    assert np.array_equal(photo.ids, parity.ids)
    assert photo.depth is not None
    assert parity.depth is not None
    assert np.array_equal(photo.depth, parity.depth)
    assert not np.array_equal(photo.rgb, parity.rgb)


def test_picture_is_independent_of_the_executing_engine(photo: Frame) -> None:
    assert np.array_equal(drawn(things(), "pybullet").rgb, photo.rgb)


def test_it_is_the_same_picture_on_any_number_of_cores(photo: Frame) -> None:
    drjit = pytest.importorskip("drjit")
    before = drjit.thread_count()
    try:
        for count in (1, 9):  # more than there are blocks of pixels
            drjit.set_thread_count(count)
            assert np.array_equal(drawn(things()).rgb, photo.rgb)
    finally:
        drjit.set_thread_count(before)


def test_colours_stay_and_shadows_fall(photo: Frame) -> None:
    for number, (name, channel) in enumerate((("red", 0), ("blue", 2), ("green", 1)), start=1):
        seen = photo.rgb[photo.ids == number].mean(axis=0)
        assert seen[channel] > 1.5 * np.delete(seen, channel).max(), name
    what = things()
    (lit, shaded), _ = project(what.cameras[0], [(-0.2, -0.15, 0), (0.24, 0.13, 0)], SIZE, SIZE)
    bright, dark = (photo.rgb[int(y), int(x)].astype(float).mean() for x, y in (lit, shaded))
    assert photo.ids[int(shaded[1]), int(shaded[0])] == 0
    assert 130 < bright < 250
    assert 0.25 * bright < dark < 0.85 * bright


@pytest.mark.parametrize("texture", [str(TEXTURES / "glass.png"), None], ids=["glass", "opaque"])
def test_only_glass_is_seen_through(texture: str | None, photo: Frame) -> None:  # it skips without Mitsuba
    pane = body("pane", "static", (0, -0.3, 0.1), Box((0.3, 0.005, 0.3)), Surface((1.0, 1.0, 1.0), texture=texture))
    plain = things()
    behind = drawn(replace(plain, bodies=(*plain.bodies, pane)))
    x, y = project(plain.cameras[0], [(-0.14, 0, 0.1)], SIZE, SIZE)[0][0].astype(int)
    red, green, _ = behind.rgb[y, x].astype(float)
    assert behind.ids[y, x] == len(plain.bodies), "the mask is the pane's"
    assert (red > 2 * green) == (texture is not None)


def test_outlines_agree_with_the_masks() -> None:
    """The denoiser's input of plain colours has a colour for each body: the nearest one identifies it."""
    pytest.importorskip("mitsuba_oidn")
    from wmspec.sim.photo.tracer import Tracer

    what, size = things(), 96
    ids, tracer = drawn(what, look="parity", size=size).ids, Tracer(what, (size, size))
    plain = tracer._taken(tracer._plain, tracer._glowing(shot(what)), world_camera(what, shot(what)), 16)[..., :3]
    apart = np.linalg.norm(plain[:, :, None] - to_linear(np.array(list(COLORS.values()))), axis=-1)
    nearest = apart.argmin(axis=-1)
    for number, name in enumerate(COLORS):
        mine, theirs = nearest == number, ids == number
        assert (mine & theirs).sum() / (mine | theirs).sum() > 0.96, name


def test_without_mitsuba_the_remedy_is_printed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    spec = tmp_path / "one.wms"
    spec.write_text(Path(SPEED).read_text())
    done = CliRunner().invoke(main, ["render", str(spec), "--look", "photo", "-o", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert "pip install 'wmspec[photo]'" in done.output
    assert not (tmp_path / "out").exists()


def test_another_file_is_no_llvm(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "libLLVM-99.so").write_bytes(b"no library")
    monkeypatch.setenv(library.LLVM, str(tmp_path / "libLLVM-99.so"))
    with pytest.raises(WmsError, match=f"(?s)no LLVM 19 or newer.*unset {library.LLVM}"):
        library.mitsuba()


def test_with_llvm_the_picture_is_nearly_the_same(photo: Frame, monkeypatch: pytest.MonkeyPatch) -> None:
    if not (path := library.newest_llvm()):
        pytest.skip("there is no LLVM for Mitsuba here")
    monkeypatch.setenv(library.LLVM, path)
    fast = drawn(things())
    assert np.abs(fast.rgb.astype(int) - photo.rgb).mean() < 4


def test_light_passes_ceilings_without_shadows() -> None:
    pytest.importorskip("mitsuba_oidn")
    from wmspec.sim.photo.tracer import Tracer

    white, half = Surface((0.9, 0.9, 0.9)), Box((2.0, 2.0, 0.05))
    slabs = [body("floor", "static", (0, 0, 0), half, white), body("ceiling", "static", (0, 0, 2.5), half, white)]
    for i, (x, y) in enumerate(((2, 0), (-2, 0), (0, 2), (0, -2))):
        wall = Box((0.05 if x else 2.0, 0.05 if y else 2.0, 1.25))
        slabs.append(body(f"wall{i}", "static", (x, y, 1.25), wall, white))
    eye = Camera("eye", look_at((0, -1.5, 1.2), (0, 2, 1.6)), math.radians(80), 0.05, 10.0)
    closed = scene(*slabs, cameras=(eye,))
    means = {}
    for shadows in (True, False):
        light = Light(np.array([0.0, 0.0, -1.0]), shadows=shadows)
        what = Scene(**{**vars(closed), "light": light})
        means[shadows] = Tracer(what, (24, 24), 8).draw(shot(what)).mean(axis=(1, 2))
    assert means[True].max() < 20, "a closed room is dark"
    assert means[False][0] > 40, "the ceiling is seen, though light comes from below it"
    assert means[False][-1] > 120


def test_only_what_is_wide_and_above_the_eye_is_a_ceiling() -> None:
    light, eye = Light(np.array([0.0, 0.0, -1.0]), shadows=False), np.array([0.0, 0.0, 1.5])

    def corners(half: float, low: float, aside: float = 0.0) -> Any:
        return np.array([aside - half, -half, low]), np.array([aside + half, half, low + 0.1])

    every = [corners(4, 2.5), corners(4, 0), corners(0.5, 2), corners(4, 2.5, 9)]
    ((low, high),) = ceiling_lights(light, every, eye)
    assert low[2] == high[2] < 2.5
    assert not ceiling_lights(Light(light.direction), every, eye)


def test_sun_has_the_intensity_of_the_scene() -> None:
    """The irradiance of a surface that faces it is pi times its share, and the sky's is half as much again."""
    down = np.array([0.0, 0.0, -1.0])
    rows = 256
    polar = (np.arange(rows) + 0.5) / rows * math.pi
    solid = np.sin(polar)[:, None, None] * (math.pi / rows) ** 2

    def falls(light: Light) -> float:
        cosine = np.clip(directions(rows)[..., 2:], 0, None)
        return float((environment_map(light, (0.8, 0.8, 0.8), rows) * cosine * solid).sum() / 3 / math.pi)

    assert falls(Light(down, 1.0, 0.0)) == pytest.approx(0.94, abs=0.02)  # its colour is a little warm
    assert falls(Light(down, 0.0, 1.0)) == pytest.approx(1.5, rel=0.15)


def test_dataset_names_its_renderer_and_is_drawn_again(tmp_path: Path) -> None:
    pytest.importorskip("mitsuba_oidn")
    installed("mujoco")
    how: Any = {"backend": "mujoco", "size": 32, "look": "photo", "samples": 1, "per_task": 1}
    generate(SPEED, tmp_path / "out", workers=0, **how)
    versions = json.loads((tmp_path / "out/manifest.json").read_text())["versions"]
    assert versions["mitsuba"] == f"{version('mitsuba')} {library.variant()}"
    assert "mitsuba-oidn" in versions
    again = verify(tmp_path / "out", workers=0)
    assert (again.verdict, dict(again.versions)) == ("same", {})
    parity = plan_dataset(SPEED, **{**how, "look": "parity", "samples": None})
    assert plan_dataset(SPEED, **how).fingerprint != parity.fingerprint
    assert "mitsuba" not in parity.versions


def test_an_unknown_look_is_an_error_that_names_the_looks() -> None:
    installed("mujoco")
    unknown: Any = "beauty"
    with pytest.raises(WmsError, match=r"no look `beauty`; choose `parity`, .* or `photo`, for people"):
        require_look(("mujoco",), unknown)
