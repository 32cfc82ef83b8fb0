"""What fails is a failure: an exit code, the first cause in full, and a file with the rest, never a traceback."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import wmspec
from tests.command import wmspec as wmspec_here
from tests.dataset.made import make, plan
from wmspec.core.crash import EXIT_CODE, Crash, is_own_error
from wmspec.core.tally import Tally

HERE = Path(__file__).parent
#: Where the wmspec is that is tested: the checkout, or the installed wheel.
HOME = Path(wmspec.__file__).parents[1]
FLIGHT = HERE.parent / "recipes/flight.wms"
MESSAGE = "AttributeError: there is no such thing as " + "a step " * 100
QUICK = ("--per-task", "2", "--size", "32", "-j", "1", "-o", "out")


class Shell:
    """The command line in a folder, where engines are installed that fail."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        site = [HERE / "broken", HERE.parent / "recipes/toy", HOME]
        self.environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(map(str, site)),
            "XDG_CACHE_HOME": str(folder / "cache"),
        }

    def python(self, *arguments: object, **variables: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, *map(str, arguments)],
            env=self.environment | variables,
            cwd=self.folder,
            capture_output=True,
            text=True,
            check=False,
            timeout=300,
        )

    def __call__(self, *arguments: object, code: int) -> str:
        done = self.python("-m", "wmspec", *arguments)
        assert done.returncode == code, done.stdout + done.stderr
        assert "Traceback" not in done.stdout + done.stderr
        return done.stderr

    def full_text(self) -> str:
        """What the one file of an error says."""
        (file,) = (self.folder / "cache/wmspec/errors").iterdir()
        return file.read_text()


@pytest.fixture
def shell(tmp_path: Path) -> Shell:
    return Shell(tmp_path)


# ---------------------------------------------------------------- nothing made is a failure


@pytest.mark.parametrize(
    ("made", "tried", "failed", "passed"),
    [(5, 20, 0, True), (5, 20, 2, True), (5, 20, 3, False), (0, 20, 0, False), (0, 0, 0, False), (1, 1, 1, False)],
)
def test_run_fails_without_output_or_with_a_tenth_of_failures(made: int, tried: int, failed: int, passed: bool) -> None:
    tally = Tally("question was kept", made, "instances", tried, failed, "the cause")
    assert tally.passed == passed
    assert ("no question was kept" in tally.message) == (made == 0)
    assert ("the cause" in tally.message) == (failed > 0)
    assert ("error: " in tally.message) == (not passed)


def test_generate_fails_if_every_instance_ends_in_an_internal_error(shell: Shell) -> None:
    reported = shell("generate", FLIGHT, "-b", "mistaken", *QUICK, code=1)
    assert "error: no question was kept\n" in reported
    assert f"error: 2 of 2 instances ended as internal errors, crashes or timeouts; the first: {MESSAGE}" in reported
    assert "at broken/wmspec_broken.py:" in reported
    assert str(shell.folder / "cache/wmspec/errors") in reported
    assert "Traceback" in shell.full_text()
    assert f"\n{MESSAGE}" in shell.full_text()
    again = shell("generate", FLIGHT, "-b", "mistaken", *QUICK, code=1)
    assert "error: no question was kept\n" in again, "a dataset that is whole already"
    assert "AttributeError: there is no such thing" in again
    # Nor can it be exported or evaluated.
    exported = wmspec_here("export", "out", "--to", "hf", "-o", "e", folder=shell.folder, code=1)
    assert "error: no question was written\n" in exported.output
    evaluated = wmspec_here("evaluate", "out", "-m", "random", "-o", "r.parquet", folder=shell.folder, code=1)
    assert "error: no reply could be read\n" in evaluated.output


def test_generate_fails_if_workers_die(shell: Shell) -> None:
    reported = shell("generate", FLIGHT, "-b", "dying", "--per-task", "1", *QUICK[2:], code=1)
    assert "1 of 1 instances ended as" in reported
    assert "in dying: the worker process died twice (exit code 7)" in reported


def test_a_dry_run_fails_too(shell: Shell) -> None:
    reported = shell("generate", FLIGHT, "-b", "mistaken", *QUICK[:-2], "--dry-run", code=1)
    assert MESSAGE in reported


def test_crosscheck_fails_if_nothing_was_compared(shell: Shell) -> None:
    reported = shell("crosscheck", FLIGHT, "-b", "sound,mistaken", "-n", "1", "-j", "1", "--json", "all.json", code=1)
    assert "error: no instance was compared\n" in reported
    assert MESSAGE in reported
    assert "Traceback" not in (shell.folder / "all.json").read_text()


def test_render_fails_if_one_of_several_engines_does(shell: Shell) -> None:
    reported = shell("render", FLIGHT, "-b", "mistaken,sound", "--size", "32", "-o", "out", code=1)
    assert reported.startswith(f"error: 1 of 2 engines failed; the first: {MESSAGE}\n")
    assert {path.stem.split("-")[2] for path in (shell.folder / "out").iterdir()} == {"sound"}


# ---------------------------------------------------------------- no traceback


@pytest.mark.parametrize("command", [("run", FLIGHT), ("render", FLIGHT, "-o", "out")], ids=lambda c: c[0])
def test_unexpected_error_is_one_line_with_a_file(shell: Shell, command: tuple[object, ...]) -> None:
    lines = shell(*command, "-b", "mistaken", code=EXIT_CODE).splitlines()
    assert lines[0] == f"error: {MESSAGE}"
    assert [line.split(":")[0].strip() for line in lines[1:3]] == ["at broken/wmspec_broken.py", "details"]
    assert "please report it" in lines[3]
    assert len(lines) == 4
    text = shell.full_text()
    assert f"-b mistaken\nPython {sys.version.split()[0]}" in text
    assert "\nnumpy " in text
    assert "Traceback" in text


def test_developers_may_see_the_traceback(shell: Shell) -> None:
    done = shell.python("-m", "wmspec", "run", FLIGHT, "-b", "mistaken", WMSPEC_TRACEBACK="1")
    assert (done.returncode, "Traceback" in done.stderr) == (EXIT_CODE, True)


def test_full_text_has_another_place_without_a_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    path = Crash.of(ValueError("none")).save()
    assert path is not None
    assert "ValueError: none" in path.read_text()


@pytest.mark.parametrize("name", ["exit codes", "70"])
def test_the_help_has_the_exit_codes(shell: Shell, name: str) -> None:
    assert name in shell.python("-m", "wmspec", "--help").stdout.lower()


# ---------------------------------------------------------------- doctor


def doctor(shell: Shell, engine: str) -> dict[str, dict[str, str]]:
    code = (
        "from wmspec.runtime.doctor import doctor\n"
        f"doctor.names, doctor._photo = lambda: ('{engine}',), lambda *_: []\n"
        "from wmspec.cli import main; main(['doctor', '--json'])"
    )
    done = shell.python("-c", code)
    assert done.returncode == 1, done.stderr
    return {finding["name"]: finding for finding in json.loads(done.stdout)["findings"]}


@pytest.mark.parametrize(
    ("engine", "words"),
    [("mistaken", MESSAGE.strip()), ("lacking", "cannot import name 'nowhere'"), ("dying", "nothing was said")],
)
def test_a_cause_that_is_not_known_is_shown_and_has_no_remedy(shell: Shell, engine: str, words: str) -> None:
    found = doctor(shell, engine)
    failed = found[f"{engine} executes"]
    assert words in failed["found"]
    assert failed["remedy"] == ""
    assert "report it" in failed["report"]
    assert found[f"{engine} renders"]["ok"]
    if engine != "dying":
        assert "Traceback" in shell.full_text()


def test_a_library_that_is_missing_is_known(shell: Shell) -> None:
    found = doctor(shell, "unlinked")["unlinked executes"]
    assert found["remedy"] == "install the package of your system that has libfoo.so.7"
    assert found["report"] == ""


def test_a_plug_in_that_cannot_be_loaded_is_a_finding(shell: Shell) -> None:
    assert "has no attribute 'nothing_of_that_name'" in doctor(shell, "absent")["absent"]["found"]


def test_internal_errors_differ_from_missing_packages() -> None:
    def raised(code: str, module: str) -> BaseException:
        with pytest.raises(Exception) as caught:  # noqa: PT011  whatever it is
            exec(compile(code, "x.py", "exec"), {"__name__": module})
        return caught.value

    assert is_own_error(raised("from wmspec.sim.scene import nowhere", "x"))
    assert is_own_error(raised("import backends.nowhere", "x"))
    assert is_own_error(raised("None.step", "backends.mujoco.render"))
    assert not is_own_error(raised("None.step", "mujoco.egl"))
    assert not is_own_error(raised("import no_such_package", "backends.mujoco.render"))
    assert not is_own_error(raised("raise RuntimeError('no device')", "backends.sapien.render"))


# ---------------------------------------------------------------- folders, libraries

DEEP = "d/" * 1500


def test_folder_that_lies_too_deep_is_an_error(shell: Shell) -> None:
    make(shell.folder / "set", plan(count=1, tasks=("collide",)))
    for made in ("generate", "render"):
        assert "folder" in shell(made, FLIGHT, "-b", "sound", "-o", DEEP, code=2), made
    commands = [
        ("compile", FLIGHT, "-o", DEEP),
        ("export", "set", "--to", "hf", "-o", DEEP),
        ("evaluate", "set", "-m", "random", "-o", f"{DEEP}r.parquet"),
        ("view", "set", "-o", f"{DEEP}v.html"),
    ]
    for command in commands:
        assert "folder" in wmspec_here(*command, folder=shell.folder, code=2).output, command
    assert not (shell.folder / "d").exists()


def test_chain_of_libraries_is_one_sentence(shell: Shell) -> None:
    for number in range(3000):
        (shell.folder / f"l{number}.wms").write_text(f"use l{number + 1}\n" if number < 2999 else "let z = 1\n")
    reported = wmspec_here("check", "l0.wms", folder=shell.folder, code=2).stderr
    assert reported.startswith("error: the spec has more than 50 libraries that use one another in a row")
    assert reported.count("error") == 1


@pytest.mark.parametrize("command", [["list"], ["run"], ["generate", "-o", "out"]], ids=lambda c: c[0])
def test_libraries_that_use_the_next_twice_are_bounded(shell: Shell, command: list[str]) -> None:
    for number in range(30):
        following = f"use l{number + 1} as a\nuse l{number + 1} as b\n" if number < 29 else ""
        (shell.folder / f"l{number}.wms").write_text(f"{following}let k = {number}\n")
    (shell.folder / "t.wms").write_text(f"use l0\n{FLIGHT.read_text()}")
    reported = wmspec_here(command[0], "t.wms", *command[1:], folder=shell.folder, code=2).stderr
    assert reported.startswith("error: the spec has more than 500 libraries, each counted as often as it has a name")
    assert reported.count("error") == 1
