"""wmspec as a user types it."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.command import wmspec as command
from tests.engines import installed
from wmspec.api import load
from wmspec.lang.parse.files import library_folder

SPECS = library_folder().parent
SPEED = Path(__file__).parent / "specs/speed_tabletop.wms"
COLLIDE = SPECS / "prediction/mechanistic/collide.wms"
STAGE = Path(__file__).parents[1] / "stage/data/collide.usda"
BALL = """#usda 1.0
def Sphere "ball" (
    apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]
) {
}
"""
WMSPEC = Path(sys.executable).with_name("wmspec")


def wmspec(*args: object, folder: Path, code: int = 0, **env: str) -> subprocess.CompletedProcess[str]:
    """Run a command as a process of its own: where `command`, in this one, would not do."""
    done = subprocess.run(
        [str(WMSPEC), *map(str, args)], cwd=folder, env=os.environ | env, capture_output=True, text=True, check=False
    )
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    return done


def test_check_and_list_bundled_specs(tmp_path: Path) -> None:
    assert "collide: 1,728 instances, no mistakes" in wmspec("check", SPECS, folder=tmp_path).stdout
    listed = json.loads(command("list", "--json", folder=tmp_path).stdout)
    sizes = {row["task"]: row["instances"] for row in listed}
    assert sizes["speed_tabletop"] >= 2304, "fewer than the paper's instances"
    assert sizes["collide"] >= 1728, "fewer than the paper's instances"
    assert all(len(row["factors"]) >= 3 for row in listed)


def test_a_list_has_a_line_for_each_task(tmp_path: Path) -> None:
    some = SPECS / "perception/vision"
    listed = json.loads(command("list", "--json", some, folder=tmp_path).stdout)
    assert len(listed) >= 3
    lines = command("list", some, folder=tmp_path, COLUMNS="40").stdout.splitlines()
    assert lines[0].split() == ["task", "dimension", "instances", "groups", "paper's", "factors"]
    assert [line.split()[0] for line in lines[1 : len(listed) + 1]] == [row["task"] for row in listed], "a line a task"
    for line, row in zip(lines[1:], listed, strict=False):
        assert f"{row['instances']:,}" in line
        assert all(factor in line for factor in row["factors"])


def test_three_mistakes_give_three_diagnostics(tmp_path: Path) -> None:
    spec = tmp_path / "mistakes.wms"
    spec.write_text((Path(__file__).parent.parent / "corpus/three_mistakes.wms").read_text())
    reported = command("check", spec, folder=tmp_path, code=2).stderr
    assert reported.count("^^") >= 3
    assert [line.split(":")[0] for line in reported.splitlines() if line.startswith("error")] == [
        "error[WMS203]",
        "error[WMS301]",
        "error[WMS201]",
    ]
    for remedy in ("did you mean `friction`?", "write something like `6 cm`", "did you mean `table`?"):
        assert remedy in reported
    found = json.loads(command("check", "--json", spec, folder=tmp_path, code=2).stdout)
    assert len(found["diagnostics"]) == 3


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["check", "nowhere.wms"], "nowhere.wms: cannot be read"),
        (["run", COLLIDE, "-i", "99999"], "has instances 0 to"),
        (["run", COLLIDE, "-b", "mujocco"], "did you mean `mujoco`?"),
        (["run", "nowhere.usda"], "there is no such file"),
        (["run", "folder.usda"], "it is a folder, not a file"),
        *((["check", f], f"{f}: it is a USD stage, not a spec; `wmspec run {f}") for f in ("a.usda", "a.usdc")),
        (["crosscheck", "a.usda"], "it is a USD stage, not a spec; `wmspec run a.usda"),
        (["run", "unnamed"], "it is a USD stage, not a spec; let its name end in .usd"),
        (["run", STAGE, "--for", "1ms"], "1ms: shorter than one sample; ask for at least 4.17ms"),
        (["run", STAGE, "--for", "soon"], "expected a time such as 2s"),
        (["render", COLLIDE, "--size", "7", "-o", "out"], "expected pixels such as 384"),
        (["generate", COLLIDE, "-o", "out", "--shard", "3/2"], "shard `3/2`: expected I/N, such as 1/8"),
        (["generate", COLLIDE, "-o", "out", "--shard", "0/2"], "shard `0/2`: expected"),
        (["generate", COLLIDE, "-o", "out", "--shard", "half"], "shard `half`: expected"),
        (["generate", COLLIDE, "-o", "out", "--reuse", "nowhere"], "nowhere holds no dataset"),
        (["list", "."], "there is no .wms file"),
    ],
)
def test_mistake_on_the_command_line_is_one_sentence(args: list[object], said: str, tmp_path: Path) -> None:
    (tmp_path / "folder.usda").mkdir()
    (tmp_path / "a.usda").write_text('#usda 1.0\n( upAxis = "Z" )\n')
    (tmp_path / "a.usdc").write_bytes(b"PXR-USDC\xff\xfe")
    (tmp_path / "unnamed").write_text("#usda 1.0\n")
    assert said in command(*args, folder=tmp_path, code=2).stderr


def test_an_error_of_the_system_is_one_sentence(tmp_path: Path) -> None:
    reported = wmspec("generate", COLLIDE, "-o", "/proc/nowhere", folder=tmp_path, code=2).stderr
    assert "/proc" in reported
    assert len(reported.splitlines()) == 1


@pytest.mark.parametrize(
    ("args", "current"),
    [
        (["recast", "photos.csv"], "import-images"),
        (["seal", "private"], "attest"),
        (["arm", "iiwa.toml"], "import-arm"),
        (["conform"], "conformance"),
        (["run", COLLIDE, "--redrawn", "3"], "--redraw"),
        (["audit", "out", "--pictures-of=400"], "--max-images"),
        (["list", "--only-dimension", "perception"], "--dimension"),
    ],
)
def test_a_former_name_gives_one_line_with_the_current_name(args: list[object], current: str, tmp_path: Path) -> None:
    (line,) = command(*args, folder=tmp_path, code=2).stderr.splitlines()
    assert line.startswith("error: `")
    assert line.endswith(f"{current}`")


STIFF = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Sphere "b" ( prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"] )
{
    double radius = 0.1
}
def PhysicsRevoluteJoint "j" ( prepend apiSchemas = ["PhysicsDriveAPI:angular"] )
{
    rel physics:body1 = </b>
    float drive:angular:physics:damping = 1e7
}
"""


def test_of_several_engines_those_that_can_execute_it_do(tmp_path: Path) -> None:
    for engine in ("mujoco", "pybullet"):
        pytest.importorskip(engine)
    (tmp_path / "stiff.usda").write_text(STIFF)
    args = ["run", "stiff.usda", "--for", "100ms", "--json", "-b"]
    both = command(*args, "mujoco,pybullet", folder=tmp_path, code=1)
    ran, refused = json.loads(both.stdout)
    assert (ran["engine"], refused["engine"]) == ("mujoco", "pybullet")
    assert refused["refused"][0]["prim"] == "/j"
    assert "would overshoot" in both.stderr
    alone = command(*args, "pybullet", folder=tmp_path, code=2)
    assert json.loads(alone.stdout) == [refused]


def test_compile_leaves_a_stage_and_an_mjcf_that_stand_alone(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    slow = next(i for i in load(COLLIDE) if (i.factors["fill"], i.factors["pace"]) == (0.15, -1)).index
    command("compile", COLLIDE, "--backend", "mujoco", "--instance", slow, "-o", "out", folder=tmp_path)
    model = mujoco.MjModel.from_xml_path(str(next((tmp_path / "out").rglob("*.xml"))))
    assert {model.body(i).name for i in range(model.nbody)} >= {"ball", "crate", "floor"}
    from pxr import Usd

    stages = [Usd.Stage.Open(str(tmp_path / f"out/collide/{slow:06d}{run}.usda")) for run in ("", ".light_fast")]
    truth, following = (s.GetAttributeAtPath("/World/Episode/Actions/push.wms:speed").Get() for s in stages)
    assert following > 1.4 * truth


def test_a_stage_on_disk_runs_like_its_spec(tmp_path: Path) -> None:
    installed("pybullet")
    command("compile", COLLIDE, "--instance", 7, "-o", "out", folder=tmp_path)
    run = ["run", "-b", "pybullet", "--json"]
    there = command(*run, "out/collide/000007.usda", folder=tmp_path).stdout
    assert json.loads(there) == json.loads(command(*run, COLLIDE, "-i", 7, folder=tmp_path).stdout)


WALL = "object wall { shape: cube  size: 20 cm  color: green  on: floor at (40 cm, 0)  fixed: true }"
MARBLE = "object ball { shape: sphere  size: 10 cm  color: red  on: floor at (0, 0) }"


@pytest.mark.parametrize("objects", [(WALL, MARBLE), (MARBLE, WALL)])
def test_touch_of_a_fixed_object_is_reported_in_either_order(objects: tuple[str, str], tmp_path: Path) -> None:
    installed("pybullet")
    push = "action push = launch(ball, direction: right, speed: 1 m/s)  horizon 0.5 s  observe front at [0 s]"
    (tmp_path / "t.wms").write_text("\n".join(("use room", "task t : custom {", *objects, push, "}")))
    run = ["run", "t.wms", "-b", "pybullet"]
    said = command(*run, folder=tmp_path).stdout
    contacts = json.loads(command(*run, "--json", folder=tmp_path).stdout)[0]["contacts"]
    assert "ball touches wall from 0.3" in said
    assert {c["first"] for c in contacts} == {"ball"}
    assert said.count(" touches ") == len(contacts)


def test_actual_duration_of_a_stage_is_reported(tmp_path: Path) -> None:
    """10 ms are nearest to two samples of 1/240 s."""
    installed("pybullet")
    (tmp_path / "ball.usda").write_text(BALL)
    reported = command("run", "-b", "pybullet", "ball.usda", "--for", "10ms", folder=tmp_path).stdout
    assert "pybullet, 0.00833333 s" in reported


def test_place_of_a_broken_stage_is_reported_once(tmp_path: Path) -> None:
    (tmp_path / "broken.usda").write_text('#usda 1.0\ndef Xform "a" {\n    double x =\n}\n')
    reported = command("run", "broken.usda", "--for", "1s", folder=tmp_path, code=2).stderr
    assert "broken.usda: not a stage that USD can open: broken.usda:3:" in reported
    (tmp_path / "part.usda").write_text('#usda 1.0\ndef Xform "a" (\n    references = @none.usda@\n) {\n}\n')
    reported = command("run", "part.usda", "--for", "1s", folder=tmp_path, code=2).stderr
    assert reported.startswith("error: /a: Could not open asset @")
    assert len(reported.splitlines()) == 1


def test_pictures_are_written(tmp_path: Path) -> None:
    installed("pybullet")
    from PIL import Image

    command("render", SPEED, "-b", "pybullet", "--size", "96x64", "-o", "a folder/é", folder=tmp_path)
    pictures = sorted((tmp_path / "a folder/é").glob("*.png"))
    assert len(pictures) == 4
    assert all(Image.open(p).size == (96, 64) for p in pictures)
