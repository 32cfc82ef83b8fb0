"""`wmspec run` of a file without a spec: URDF, MJCF and meshes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import trimesh
from click.testing import CliRunner

from tests.assets.specs import CABINET
from wmspec.cli.run import run_command

pytest.importorskip("mujoco")

MJCF = """<mujoco><worldbody><geom type="plane" size="1 1 1"/>
<body name="ball" pos="0 0 1"><freejoint/><geom size=".1"/></body></worldbody></mujoco>"""


def final(path: Path, *options: str) -> dict[str, list[float]]:
    """The final positions of the bodies that can move."""
    result = CliRunner().invoke(run_command, [str(path), "--backend", "mujoco", "--json", *options])
    assert result.exit_code == 0, result.output
    (summary,) = json.loads(result.stdout)
    return {name: body["middle"] for name, body in summary["bodies"].items()}


def test_a_urdf_stands_on_a_ground(tmp_path: Path) -> None:
    (tmp_path / "cabinet.urdf").write_bytes(CABINET.read_bytes())
    found = final(tmp_path / "cabinet.urdf", "--for", "0.5s")
    assert "cabinet_door" in found


def test_an_mjcf_keeps_its_place_above_its_plane(tmp_path: Path) -> None:
    (tmp_path / "ball.xml").write_text(MJCF)
    assert final(tmp_path / "ball.xml")["ball"][2] == pytest.approx(0.1, abs=2e-3)
    (tmp_path / "ball.xml").write_text(MJCF.replace('size="1 1 1"', 'pos="0 0 -.5" size="1 1 1"'))
    assert final(tmp_path / "ball.xml")["ball"][2] == pytest.approx(-0.4, abs=2e-3)
    (tmp_path / "ball.xml").write_text(MJCF.replace('type="plane"', 'type="sphere" pos="9 0 0"'))
    assert final(tmp_path / "ball.xml", "--for", "1s")["ball_ball"][2] == pytest.approx(1 - 9.81 / 2, abs=0.02)


def test_a_gltf_stands_upright(tmp_path: Path) -> None:
    trimesh.creation.box((0.2, 0.8, 0.4)).export(tmp_path / "chair 1.glb")
    assert final(tmp_path / "chair 1.glb")["chair_1"][2] == pytest.approx(0.4, abs=2e-3)


def test_strict_and_missing_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "ball.xml").write_text(MJCF)
    for file, options, message in (
        ("ball.xml", ["--strict"], "planes are not supported"),
        ("none.urdf", [], "there is no such file"),
    ):
        result = CliRunner().invoke(run_command, [str(tmp_path / file), *options])
        assert message in str(result.exception)


def test_meshes_lie_below_the_current_folder_or_that_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("robots", "meshes"):
        (tmp_path / name).mkdir()
    trimesh.creation.box((0.2, 0.2, 0.4)).export(tmp_path / "meshes/m.stl")
    shape = '<geometry><mesh filename="package://meshes/m.stl"/></geometry>'
    (tmp_path / "robots/a.urdf").write_text(
        f'<robot name="r"><link name="a"><visual>{shape}</visual><collision>{shape}</collision></link></robot>'
    )
    monkeypatch.chdir(tmp_path / "robots")
    result = CliRunner().invoke(run_command, ["a.urdf"])
    assert "below the current folder or that of the file; run wmspec in a folder above both" in str(result.exception)
    monkeypatch.chdir(tmp_path)
    assert final(Path("robots/a.urdf"))["a"][2] == pytest.approx(0.2, abs=2e-3)


def test_a_mesh_in_millimetres_is_reported(tmp_path: Path) -> None:
    trimesh.creation.box((200, 400, 600)).export(tmp_path / "a.stl")
    result = CliRunner().invoke(run_command, [str(tmp_path / "a.stl"), "--for", "0.1s"])
    assert result.exit_code == 0
    assert "the mesh of `a` is 600 m long" in result.output
    assert "units: mm" in result.output
