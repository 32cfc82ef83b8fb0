"""A release says one thing everywhere: its version, its changes, its extras, and the commands of its workflows."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

from wmspec import __version__

ROOT = Path(__file__).parents[2]
CHANGELOG = (ROOT / "CHANGELOG.md").read_text()
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
FORMS = sorted((ROOT / ".github").rglob("*.yml"))
WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))
#: Extras for working on wmspec, which nobody needs to use it.
DEVELOPMENT = {"dev", "docs", "notebooks"}


def read(path: Path) -> Any:
    # YAML 1.1 reads `on` as true; as text, all keys are as they are written.
    return yaml.load(path.read_text(), Loader=yaml.BaseLoader)


def jobs(workflow: Path) -> list[dict[str, Any]]:
    return list(read(workflow)["jobs"].values())


def test_the_newest_entry_of_the_changelog_is_this_version() -> None:
    versions = re.findall(r"^## \[(.+?)\] - (\d{4}-\d\d-\d\d)$", CHANGELOG, re.MULTILINE)
    assert versions[0][0] == __version__
    citation = read(ROOT / "CITATION.cff")
    assert (citation["version"], citation["date-released"]) == versions[0]
    assert citation["license"] == PROJECT["license"]
    assert f"| the package | {__version__} |" in (ROOT / "docs/compatibility.md").read_text()


def test_the_changelog_has_one_line_an_entry() -> None:
    body = CHANGELOG.partition("\n## ")[2]
    lines = [line for line in body.splitlines()[1:] if line and not line.startswith(("## [", "### "))]
    assert not [line for line in lines if not line.startswith("- ") and line != "Not published."]
    assert not [line for line in lines if len(line) > 180]
    kinds = set(re.findall(r"^### (.*)$", body, re.MULTILINE))
    assert kinds <= {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}


def test_the_extra_all_is_every_extra_that_users_need() -> None:
    extras = PROJECT["optional-dependencies"]

    def reached(extra: str) -> set[str]:
        named = re.findall(r"wmspec\[(.*?)\]", " ".join(extras[extra]))
        return {extra}.union(*(reached(other) for names in named for other in names.split(",")))

    assert reached("all") == set(extras) - DEVELOPMENT
    assert reached("engines") == {"engines", *PROJECT["entry-points"]["wmspec.backends"]}


@pytest.mark.parametrize("path", FORMS, ids=lambda path: path.stem)
def test_forms_and_workflows_are_yaml(path: Path) -> None:
    content = read(path)
    if path.parent.name == "ISSUE_TEMPLATE" and path.stem != "config":
        assert {"name", "description", "body"} <= set(content)
        fields = [field for field in content["body"] if field["type"] != "markdown"]
        assert fields
        assert len({field["id"] for field in fields}) == len(fields)


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.stem)
def test_workflows_have_few_rights_and_run_commands_that_exist(workflow: Path) -> None:
    assert read(workflow)["permissions"] == {"contents": "read"}
    steps = [step for job in jobs(workflow) for step in job["steps"]]
    for action in (step["uses"] for step in steps if "uses" in step):
        assert re.fullmatch(r"[\w.-]+/[\w.-]+@(v\d+|release/v\d+)", action)
    commands = "\n".join(step["run"] for step in steps if "run" in step)
    for target in re.findall(r"\bmake (\w+)$", commands, re.MULTILINE):
        done = subprocess.run(["make", "-n", target], cwd=ROOT, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    for script in re.findall(r"^[\w./]*/[\w./]+$", commands, re.MULTILINE):
        assert (ROOT / script).stat().st_mode & 0o100, script


def test_only_jobs_that_need_no_secret_publish() -> None:
    """Publishing is by a token of the run itself: nothing is stored, and building has no right to publish."""
    release = read(ROOT / ".github/workflows/release.yml")["jobs"]
    assert {name for name, job in release.items() if "id-token" in job.get("permissions", {})} == {"publish"}
    assert "secrets." not in (ROOT / ".github/workflows/release.yml").read_text()


def test_a_release_is_made_of_a_wheel_that_needs_only_its_dependencies() -> None:
    """Which takes long, so no other workflow tries it."""
    steps = [step.get("run", "") for step in read(ROOT / ".github/workflows/release.yml")["jobs"]["build"]["steps"]]
    assert steps.index(".ci/run") < steps.index(".venv/bin/pytest -m slow tests/package") < steps.index("make dist")


def test_no_page_promises_wmspec_from_an_index() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "docs").rglob("*.ipynb")]
    promise = re.compile(r"pip install (wmspec\b|'?wmspec\[(all|engines|mujoco|pybullet|sapien)\b)")
    assert not [str(page) for page in pages if promise.search(page.read_text())]
