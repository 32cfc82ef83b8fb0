"""Untrusted traces and stages: nonsense is not drawn, and nothing is written outside the named folder."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.trust.made import STAGE, below, resaved, wmspec


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("trace")
    (folder / "ball.usda").write_text(STAGE.format(task='"falls"'))
    result = wmspec("run", folder / "ball.usda", "-b", "mujoco", "-o", folder / "ball.npz")
    assert result.exit_code == 0, result.output
    return folder / "ball.npz"


@pytest.fixture
def trace(tmp_path: Path, original: Path) -> Path:
    (tmp_path / "in").mkdir()
    copy = tmp_path / "in" / "ball.npz"
    copy.write_bytes(original.read_bytes())
    return copy


def spoiled(value: float) -> Any:
    def change(array: np.ndarray) -> np.ndarray:
        array[3] = value
        return array

    return change


def doubled(arc: str) -> str:
    """A stage of a few lines that composes to 2^30 prims."""
    kids = "\n".join(
        f'class "C{n}" {{\ndef "a" ({arc} = </C{n - 1}>) {{\n}}\ndef "b" ({arc} = </C{n - 1}>) {{\n}}\n}}'
        for n in range(1, 30)
    )
    return f'#usda 1.0\ndef "all" ({arc} = </C29>) {{\n}}\nclass "C0" {{\n}}\n{kids}\n'


@pytest.mark.parametrize(
    ("arrays", "reported"),
    [
        ({"position": spoiled(np.nan)}, "`position` has numbers that are not finite"),
        ({"position": lambda a: a[:, :, :2]}, "`position` is float64 (25, 1, 2), expected float64 (25, 1, 3)"),
        ({"position": lambda a: a.astype(complex)}, "`position` is complex128"),
        ({"orientation": spoiled(0.0)}, "an orientation is no unit quaternion"),
        ({"time": lambda a: a[:0]}, "`position` is float64"),
        ({"time": spoiled(0.0)}, "its times do not begin at 0 and go on"),
        ({"engine": np.array("../../evil")}, "its engine has no name"),
        ({"engine": np.array(7)}, "there is no"),
        ({"bodies": np.array(["cube"])}, "its bodies are not those of its stage, ball"),
        ({"contacts": np.array([["a", "b"]]), "contact_times": np.array([[0.0, 1.0]])}, "a contact is of no bodies"),
        ({"contacts": np.array([["a", "b"]])}, "not a trace of wmspec"),
        ({"time": None}, "not a trace of wmspec"),
        ({"stage": np.array("#usda 1.0\n(subLayers = [@/etc/hosts@])")}, "its stage uses files of its own"),
        ({"stage": np.array(doubled("inherits"))}, "has more than 200,000 prims after composition"),
        ({"stage": np.array(doubled("references"))}, "has more than 200,000 prims after composition"),
    ],
)
def test_a_trace_that_is_not_one(tmp_path: Path, trace: Path, arrays: dict[str, Any], reported: str) -> None:
    resaved(trace, **arrays)
    result = wmspec("render", trace, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert reported in result.output
    assert "ball.npz" in result.output or "engine" in reported or "no" in reported


def test_a_trace_with_too_few_samples(tmp_path: Path, trace: Path) -> None:
    names = ("time", "position", "orientation", "linear_velocity", "angular_velocity")
    resaved(trace, **dict.fromkeys(names, lambda a: a[:3]))
    result = wmspec("render", trace, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert "it has 3 samples; its stage lasts for 25" in result.output


def test_overlong_array_length_allocates_nothing(tmp_path: Path, trace: Path) -> None:
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)})
    with zipfile.ZipFile(trace, "a") as archive:
        archive.writestr("more.npy", head.getvalue())
    result = wmspec("render", trace, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert "not a trace of wmspec" in result.output


@pytest.mark.parametrize("end", [0, 1, 30, 400, -1, -100])
def test_a_trace_that_is_cut_off(tmp_path: Path, trace: Path, end: int) -> None:
    trace.write_bytes(trace.read_bytes()[:end])
    result = wmspec("render", trace, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert "not a trace of wmspec" in result.output


@pytest.mark.parametrize("task", ['"../../evil"', '"/tmp/evil"', '"."', '"x y"', '"' + "x" * 300 + '"'])
@pytest.mark.parametrize("command", ["run", "render"])
def test_a_task_whose_name_leads_out(tmp_path: Path, task: str, command: str) -> None:
    """`render` wrote its pictures to wherever the stage's `wms:task` said."""
    stage = tmp_path / "evil.usda"
    stage.write_text(STAGE.format(task=task))
    before = below(tmp_path)
    result = wmspec(command, stage, "-b", "mujoco", *(["-o", tmp_path / "deep/out"] if command == "render" else []))
    assert result.exit_code == 2
    assert "is not a valid name" in result.output
    assert below(tmp_path) == before


@pytest.mark.parametrize("seconds", [601, 36_000_000])
def test_an_episode_that_lasts_too_long(tmp_path: Path, seconds: int) -> None:
    stage = tmp_path / "long.usda"
    stage.write_text(STAGE.format(task='"long"').replace("0.1", f"{seconds}", 1))
    result = wmspec("run", stage, "-b", "mujoco")
    assert result.exit_code == 2
    assert "has more than 600 seconds" in result.output


def test_a_trace_is_not_run_as_a_spec(tmp_path: Path) -> None:
    (tmp_path / "outside.txt").write_text("secret")
    (tmp_path / "ball.npz").symlink_to(tmp_path / "outside.txt")
    result = wmspec("run", tmp_path / "ball.npz", "-b", "mujoco")
    assert result.exit_code == 2
    assert "`wmspec render` draws it" in result.stderr
    assert "secret" not in result.stderr


def test_a_task_may_be_named_by_its_folders(tmp_path: Path) -> None:
    stage = tmp_path / "ball.usda"
    stage.write_text(STAGE.format(task='"prediction/mechanistic/falls"'))
    result = wmspec("render", stage, "-b", "mujoco", "-o", tmp_path / "out", "--size", "32")
    assert result.exit_code == 0, result.output
    assert all(path.name.startswith("falls-000000-mujoco-") for path in below(tmp_path / "out"))


@pytest.mark.parametrize(
    ("line", "reported"),
    [
        ('string radius = "double"', "radius is a text, expected a number"),
        ("double3 radius = (1, 2, 3)", "radius is 3 numbers, expected a number"),
        ('string physics:velocity = "fast"', "physics:velocity is a text, expected 3 numbers"),
        ("token[] physics:velocity = []", "physics:velocity is texts, expected 3 numbers"),
        ('double radius = 0.1\n  string physxRigidBody:linearDamping = "low"', "is a text, expected a number"),
    ],
)
def test_a_value_of_another_type_than_its_schema_says(tmp_path: Path, line: str, reported: str) -> None:
    stage = tmp_path / "ball.usda"
    stage.write_text(STAGE.format(task='"falls"').replace("double radius = 0.1", line))
    result = wmspec("run", stage, "-b", "mujoco")
    assert result.exit_code == 2
    assert reported in " ".join(result.output.replace(";", ",").split())


def test_a_trace_of_a_stage_with_instances_is_read(tmp_path: Path) -> None:
    """A flattened stage keeps the prototypes of instances, and refers to them."""
    look = '\ndef "look" (\ninstanceable = true\nreferences = </cone>\n) {\n}\n'
    stage = STAGE.format(task='"falls"').replace("double radius = 0.1\n", f"double radius = 0.1\n{look}")
    (tmp_path / "ball.usda").write_text(stage + 'class "cone" {\ndef Cone "tip" {\n}\n}\n')
    assert wmspec("run", tmp_path / "ball.usda", "-b", "mujoco", "-o", tmp_path / "ball.npz").exit_code == 0
    result = wmspec("render", tmp_path / "ball.npz", "-o", tmp_path / "out", "--size", "32")
    assert result.exit_code == 0, result.output
