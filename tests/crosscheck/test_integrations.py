"""The plugin of pytest, the hooks of pre-commit and the action of GitHub, in a fresh repository with two specs."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
import yaml

from tests.command import wmspec
from tests.crosscheck.repository import PAIR, commit, git, make
from tests.shared import Shared

ROOT = Path(__file__).parents[2]
CHECKOUT = pytest.mark.skipif(not (ROOT / "pyproject.toml").exists(), reason="these files are those of a checkout")


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    return make(tmp_path / "repository")


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """A PATH on which `wmspec` is the one under test."""
    programs = tmp_path / "bin"
    programs.mkdir()
    script = programs / "wmspec"
    script.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m wmspec "$@"\n')
    script.chmod(0o755)
    path = os.pathsep.join([str(programs), os.environ["PATH"]])
    imports = [str(ROOT), os.environ.get("PYTHONPATH", "")] if not os.environ.get("PYTHONSAFEPATH") else []
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("GITHUB_", "PYTEST_", "GIT_"))}
    return kept | {"PATH": path} | ({"PYTHONPATH": os.pathsep.join(filter(None, imports))} if imports else {})


def add_another_disagreement(repository: Path) -> None:
    text = (repository / "specs/tumble.wms").read_text()
    (repository / "specs/other.wms").write_text(text.replace("task tumble :", "task other :"))


@pytest.fixture
def known(shared: Shared, tmp_path: Path) -> Path:
    """A folder with `cache`, the results for the repository, and `known.json`, the baseline of its disagreement."""

    def fill(folder: Path) -> None:
        options = ["-b", PAIR, "-n", 3, "-j", 1, "--cache", "../cache", "--baseline", "../known.json"]
        wmspec("crosscheck", "specs", *options, "--update-baseline", folder=make(folder / "repository"))

    return Path(shutil.copytree(shared.folder("integrations", fill), tmp_path / "known"))


# ---------------------------------------------------------------- pytest


def run_pytest(repository: Path, environment: dict[str, str], *arguments: str) -> tuple[int, dict[str, str], str]:
    """Return the exit code, the outcome of each test by its name, and the output."""
    (repository / "pytest.ini").write_text("[pytest]\n")
    plugins = ("-p", "wmspec.pytest_plugin", "-p", "xdist.plugin", "-p", "no:cacheprovider")
    options = ("--wmspec-sample", "3", "--wmspec-backends", PAIR, "--wmspec-cache", "../cache", "--junitxml", "out.xml")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *plugins, "--wmspec", *options, *arguments],
        cwd=repository,
        env=environment | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    cases = ET.parse(repository / "out.xml").getroot().iter("testcase")
    outcomes = {
        f"{case.get('classname')}::{case.get('name')}": case[0].tag if len(case) else "passed" for case in cases
    }
    return done.returncode, outcomes, done.stdout + done.stderr


def test_pytest_has_a_test_for_each_task_and_check(repository: Path, environment: dict[str, str]) -> None:
    code, outcomes, output = run_pytest(repository, environment, "-rA", "specs")
    assert (code, outcomes) == (
        1,
        {
            "specs.plate.wms::check": "passed",
            "specs.race.wms::check": "passed",
            "specs.race.wms.race::crosscheck": "passed",
            "specs.tumble.wms::check": "passed",
            "specs.tumble.wms.tumble::crosscheck": "failure",
        },
    )
    assert "mujoco answers the blue cube, sapien the red cube" in output
    assert "Traceback" not in output
    again = run_pytest(repository, environment, "-rA", "-n", "2", "specs")
    assert again[:2] == (code, outcomes)


def test_pytest_accepts_what_a_baseline_holds(repository: Path, known: Path, environment: dict[str, str]) -> None:
    add_another_disagreement(repository)
    options = ("--wmspec-cache", str(known / "cache"), "--wmspec-baseline", str(known / "known.json"))
    code, outcomes, _ = run_pytest(repository, environment, *options, "specs")
    assert code == 1
    assert "specs.tumble.wms.tumble::crosscheck" in outcomes
    assert [name for name, outcome in outcomes.items() if outcome == "failure"] == ["specs.other.wms.other::crosscheck"]


def test_pytest_reports_a_broken_spec_with_its_place(repository: Path, environment: dict[str, str]) -> None:
    race = repository / "specs/race.wms"
    race.write_text(race.read_text().replace("object far ", "object far {"))
    (repository / "specs/latin.wms").write_bytes(b"task \xff")
    code, outcomes, output = run_pytest(repository, environment, "specs/race.wms", "specs/latin.wms")
    assert (code, set(outcomes.values())) == (1, {"failure"})
    assert set(outcomes) == {"specs.race.wms::check", "specs.latin.wms::check"}
    assert re.search(r"--> specs/race\.wms:\d+:\d+", output)
    assert "not UTF-8 text" in output
    assert "Traceback" not in output


def test_without_the_option_pytest_collects_no_spec(repository: Path, environment: dict[str, str]) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "wmspec.pytest_plugin", "-p", "no:cacheprovider", "specs"],
        cwd=repository,
        env=environment | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == pytest.ExitCode.NO_TESTS_COLLECTED


@CHECKOUT
def test_the_package_registers_the_plugin() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["entry-points"]["pytest11"] == {"wmspec": "wmspec.pytest_plugin"}


# ---------------------------------------------------------------- pre-commit


@CHECKOUT
def test_the_hooks_check_and_format_what_is_committed(repository: Path, environment: dict[str, str]) -> None:
    """The hooks as they are, in the environment of the tests instead of one that pre-commit installs."""
    from pre_commit.clientlib import load_manifest

    hooks = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    assert [hook["id"] for hook in load_manifest(str(ROOT / ".pre-commit-hooks.yaml"))] == [
        "wmspec-check",
        "wmspec-fmt",
    ]
    local = {"repo": "local", "hooks": [hook | {"language": "system"} for hook in hooks]}
    (repository / ".pre-commit-config.yaml").write_text(yaml.safe_dump({"repos": [local]}))
    commit(repository)

    def run() -> tuple[int, str]:
        command = [sys.executable, "-m", "pre_commit", "run", "--color", "never"]
        done = subprocess.run(command, cwd=repository, env=environment, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout

    race = repository / "specs/race.wms"
    good = race.read_text()
    race.write_text(good.replace("horizon 0.6 s", "horizon   0.6 s"))
    git(repository, "add", ".")
    code, output = run()
    assert code == 1
    assert re.search(r"wmspec check\.+Passed", output)
    assert re.search(r"wmspec fmt\.+Failed", output)
    assert race.read_text().count("horizon 0.6 s") == 1
    git(repository, "add", ".")
    assert run()[0] == 0
    race.write_text(good.replace("fastest([near, far])", "fastest([near, fare])"))
    git(repository, "add", ".")
    code, output = run()
    assert code == 1
    assert "specs/race.wms:19" in output
    assert "did you mean `far`?" in output


# ---------------------------------------------------------------- the action


class Action:
    """Executes the shell steps of `action.yml` as a runner does; steps that use other actions are left out."""

    def __init__(self, repository: Path, environment: dict[str, str], folder: Path) -> None:
        self._repository, self._folder = repository, folder
        self._environment = environment | {"GITHUB_ACTIONS": "true"}
        self._action = yaml.safe_load((ROOT / "action.yml").read_text())

    def run(self, **given: str) -> tuple[int, str, str]:
        """Return the exit code of the first step that fails, the log, and the summary of the job."""
        inputs = {name.replace("_", "-"): value for name, value in given.items()}
        assert inputs.keys() <= self._action["inputs"].keys()
        known = {f"inputs.{name}": inputs.get(name, value["default"]) for name, value in self._action["inputs"].items()}
        known |= {"runner.temp": str(self._folder / "temp"), "github.action_path": str(ROOT)}
        summary, log, code = self._folder / "summary.md", "", 0
        summary.write_text("")
        for step in self._action["runs"]["steps"]:
            if "run" in step and code == 0 and _holds(step.get("if", ""), known):
                assert step["shell"] == "bash"
                own = {name: _filled(value, known) for name, value in step.get("env", {}).items()}
                done = subprocess.run(
                    ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]],
                    cwd=self._repository,
                    env=self._environment | own | {"GITHUB_STEP_SUMMARY": str(summary)},
                    capture_output=True,
                    text=True,
                    timeout=600,
                    check=False,
                )
                code, log = done.returncode, log + done.stdout + done.stderr
        return code, log, summary.read_text()


def _filled(text: str, known: dict[str, str]) -> str:
    return re.sub(r"\$\{\{ ([\w.-]+) \}\}", lambda match: known[match[1]], text)


def _holds(condition: str, known: dict[str, str]) -> bool:
    if not condition:
        return True
    match = re.fullmatch(r"([\w.-]+) == '(\w+)'", condition)
    assert match is not None, condition
    return known[match[1]] == match[2]


@pytest.fixture
def action(repository: Path, environment: dict[str, str], tmp_path: Path) -> Action:
    return Action(repository, environment, tmp_path)


SETTINGS: dict[str, Any] = {"install": "false", "backends": PAIR, "sample": "3"}


@CHECKOUT
def test_the_action_finds_a_disagreement_and_accepts_a_known_one(action: Action, repository: Path) -> None:
    code, log, summary = action.run(**SETTINGS)
    assert code == 1
    assert "\n::error title=wmspec crosscheck-answers,file=specs/tumble.wms,line=" in log
    assert "mujoco answers the blue cube, sapien the red cube" in summary
    assert "::error" not in summary
    reports = {path.name for path in (repository / "wmspec-reports").iterdir()}
    assert reports == {f"crosscheck.{kind}" for kind in ("html", "json", "sarif", "txt", "xml")}

    known = (repository / "wmspec-reports/crosscheck.json").read_text()
    assert '"passes": false' in known
    code, log, _ = action.run(**SETTINGS, fail_under="80")
    assert code == 0
    assert "6 of 6 results are from the cache" in log


@CHECKOUT
def test_the_action_passes_its_inputs_on(action: Action, repository: Path, known: Path, tmp_path: Path) -> None:
    shutil.copytree(known / "cache", tmp_path / "temp/wmspec-cache")
    shutil.copy(known / "known.json", repository / "known it.json")
    add_another_disagreement(repository)
    settings = SETTINGS | {"baseline": "known it.json", "reports": "the reports", "max_time": "10m"}
    code, log, _ = action.run(**settings, specs="specs/race.wms specs/tumble.wms")
    assert code == 0
    assert "6 of 6 results are from the cache" in log
    assert (repository / "the reports/crosscheck.xml").exists()
    code, log, _ = action.run(**settings, changed_since="HEAD")
    assert code == 1
    assert "mujoco answers" in log
    assert "from the cache" not in log


@CHECKOUT
def test_the_action_runs_no_text_of_an_input(action: Action, repository: Path, tmp_path: Path) -> None:
    code, log, _ = action.run(**SETTINGS, specs="specs/race.wms", baseline=f"$(touch {tmp_path}/executed)")
    assert code == 2
    assert "there is no such baseline" in log
    assert not (tmp_path / "executed").exists()


@CHECKOUT
def test_the_action_annotates_a_broken_spec(action: Action, repository: Path) -> None:
    race = repository / "specs/race.wms"
    race.write_text(race.read_text().replace("fastest([near, far])", "fastest([near, fare])"))
    code, log, _ = action.run(**SETTINGS)
    assert code == 2
    assert "::error title=wmspec WMS201,file=specs/race.wms,line=19" in log
    assert not (repository / "wmspec-reports").exists()
