"""Where a command is started: with streams that are closed or full, among pipes and devices, at no time at all."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

from tests.dataset.made import make, plan
from tests.trust.made import STAGE, wmspec
from wmspec.core.crash import EXIT_CODE
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.reader import DatasetReader

SPEC = Path(__file__).parents[1] / "endtoend/specs/speed_tabletop.wms"
FORMATTED = "use tabletop\n"


def started(way: str, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """The command line as a shell starts it, with its streams as `way` says."""
    command = [sys.executable, "-m", "wmspec", *map(str, arguments)]
    return subprocess.run(
        ["bash", "-c", f'"$@" {way}', "bash", *command], capture_output=True, text=True, check=False, timeout=120
    )


@pytest.mark.parametrize("command", [["list", SPEC], ["explain"], ["--help"]], ids=str)
def test_a_disk_that_is_full_where_the_output_goes(command: list[str | Path]) -> None:
    done = started(">/dev/full", *command)
    assert done.returncode == 2
    assert done.stderr == "error: No space left on device\n"


@pytest.mark.parametrize("way", [">&-", "<&- >&- 2>&-"])
def test_streams_that_are_closed(way: str, tmp_path: Path) -> None:
    """What was opened next took the place of such a stream, and was written into."""
    (tmp_path / "t.wms").write_text(FORMATTED)
    assert started(way, "fmt", tmp_path / "t.wms").returncode == 0
    assert (tmp_path / "t.wms").read_text() == FORMATTED
    done = started(way, "fmt", "-")
    assert done.returncode != EXIT_CODE
    assert "Traceback" not in done.stderr


@pytest.mark.engine
def test_engine_runs_without_a_listener(tmp_path: Path) -> None:
    (tmp_path / "ball.usda").write_text(STAGE.format(task='"falls"'))
    done = started(">&-", "run", tmp_path / "ball.usda", "-b", "mujoco", "-o", tmp_path / "ball.npz")
    assert (done.returncode, done.stderr) == (0, "")
    assert wmspec("render", tmp_path / "ball.npz", "-o", tmp_path / "out", "--size", "32").exit_code == 0


# ---------------------------------------------------------------- pipes and devices in place of files

COMMANDS = {
    ".wms": [["check"], ["fmt"], ["list"], ["compile", "-o", "o"], ["run"], ["generate", "-o", "o"], ["crosscheck"]],
    ".usda": [["run"], ["render", "-o", "o"]],
    ".npz": [["render", "-o", "o"]],
    ".parquet": [["evaluate", "--rescore"], ["report", "-o", "o"]],
    ".csv": [["import-images", "-o", "o", "--images", "."]],
}


@pytest.mark.parametrize(("ending", "command"), [(end, each) for end in COMMANDS for each in COMMANDS[end]], ids=str)
@pytest.mark.parametrize("kind", ["pipe", "device", "circle"])
def test_no_command_waits_for_what_has_no_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, command: list[str], kind: str
) -> None:
    monkeypatch.chdir(tmp_path)
    special(Path(f"x{ending}"), kind)
    assert wmspec(*command, f"x{ending}").exit_code == 2
    assert [path.name for path in Path().iterdir()] == [f"x{ending}"]


def special(path: Path, kind: str) -> None:
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero" if kind == "device" else path.name)


@pytest.mark.parametrize("text", ["(references = @x.usda@)", "(payload = @x.usda@)"])
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_a_stage_that_refers_to_what_has_no_end(tmp_path: Path, text: str, kind: str) -> None:
    special(tmp_path / "x.usda", kind)
    (tmp_path / "s.usda").write_text(f'#usda 1.0\n(defaultPrim = "p")\ndef Xform "p" {text} {{}}\n')
    result = wmspec("run", tmp_path / "s.usda")
    assert result.exit_code == 2
    assert "it is a pipe or a device, not a file" in result.output


PLAN = plan(count=2, tasks=("collide",))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(tmp_path_factory.mktemp("whole") / "d", PLAN).folder


@pytest.mark.parametrize("name", ["manifest.json", "plan.json", "data/collide/test-00000-of-00001.parquet"])
@pytest.mark.parametrize("kind", ["pipe", "device", "circle"])
def test_a_dataset_with_what_has_no_end(tmp_path: Path, whole: Path, name: str, kind: str) -> None:
    folder = shutil.copytree(whole, tmp_path / "d")
    path = folder / name
    path.unlink()
    special(path, kind)
    wmspec("view", folder, "-o", tmp_path / "v.html")
    with suppress(WmsError):
        DatasetReader.open(folder).intact()
    with suppress(WmsError):
        Dataset.open(folder, PLAN).close()


@pytest.mark.parametrize("said", ["abc", "nan", "-1e30", "99999999999999"])
def test_invalid_date_is_an_error_before_anything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, said: str
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", said)
    result = wmspec("generate", SPEC, "-b", "mujoco", "--per-task", "1", "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert f"SOURCE_DATE_EPOCH is invalid: {said}" in result.output
    assert not (tmp_path / "out").exists()
