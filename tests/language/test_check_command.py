"""What `wmspec check` prints: for people, for programs, for code hosts."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlparse

import pytest
from click.testing import CliRunner

from tests.examples import slow_except
from wmspec.cli import common, main
from wmspec.lang.parse.codes import CODES

CORPUS = Path(__file__).parents[1] / "corpus"
ROOT = Path(__file__).parents[2]
NAMES = sorted(path.name for path in CORPUS.glob("*.wms"))


def run(*args: object, **more: Any) -> Any:
    return CliRunner().invoke(main, ["check", *map(str, args)], **more)


def test_json_has_a_shorthand() -> None:
    path = CORPUS / "three_mistakes.wms"
    long, short = run(path, "--format", "json"), run(path, "--json")
    assert long.output == short.output
    assert [d["code"] for d in json.loads(long.output)["diagnostics"]] == ["WMS203", "WMS301", "WMS201"]
    assert long.exit_code == 2


def test_good_tasks_are_listed_beside_one_with_mistakes() -> None:
    outcome = run(CORPUS / "three_mistakes.wms", CORPUS / "good.wms", CORPUS / "as_written_scene.wms")
    assert outcome.exit_code == 2
    assert outcome.stdout.splitlines()[0] == "good: 2 instances, no mistakes"
    assert "as_written" not in outcome.stdout


@pytest.mark.parametrize("name", slow_except(NAMES[::3], NAMES))
def test_sarif_keeps_the_rules_of_its_schema(name: str) -> None:
    """The required properties, closed sets and bounds of the SARIF 2.1.0 schema for what we write."""
    log = json.loads(run(CORPUS / name, "--format", "sarif").stdout)
    assert set(log) == {"$schema", "version", "runs"}
    assert log["version"] == "2.1.0"
    (sarif_run,) = log["runs"]
    assert set(sarif_run) == {"tool", "originalUriBaseIds", "columnKind", "results"}
    bases = {name: base["uri"] for name, base in sarif_run["originalUriBaseIds"].items()} | {"": ""}
    rules = sarif_run["tool"]["driver"]["rules"]
    assert [r["id"] for r in rules] == list(CODES)
    expected = (CORPUS / name).with_suffix(".expected").read_text().splitlines()
    assert len(sarif_run["results"]) == sum(line.startswith(("error", "warning")) for line in expected)
    for result in sarif_run["results"]:
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]
        assert result["level"] in {"none", "note", "warning", "error"}
        assert result["message"]["text"]
        for location in [*result["locations"], *result.get("relatedLocations", [])]:
            place = location["physicalLocation"]
            file = place["artifactLocation"]
            assert Path(unquote(urlparse(bases[file.get("uriBaseId", "")] + file["uri"]).path)).is_file()
            region = place["region"]
            assert region["startLine"] >= 1
            assert (region["endLine"], region["endColumn"]) >= (region["startLine"], region["startColumn"])


def test_colours_appear_only_in_colour_terminals(monkeypatch: pytest.MonkeyPatch) -> None:
    path = CORPUS / "three_mistakes.wms"
    assert "\x1b[" not in run(path, color=True).stderr
    monkeypatch.setattr(common, "_has_colour", lambda: True)
    assert "\x1b[31m\x1b[1merror[WMS203]\x1b[0m: " in run(path, color=True).stderr


def test_no_color_is_respected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setenv("NO_COLOR", "1")
    assert not common._has_colour()
    monkeypatch.setenv("NO_COLOR", "")
    assert common._has_colour()


def test_a_mistake_in_one_file_hides_none_in_the_next(tmp_path: Path) -> None:
    """Not even those that are found only when the design is counted."""
    (tmp_path / "a.wms").write_text("task a : custom { require tru }\n")
    (tmp_path / "b.wms").write_text(
        "use tabletop\ntask b : custom { factor x in [1, 2]  require x > 5\n"
        "object o { mass: x * 1 kg  on: table } observe front at [0 s] }\n"
    )
    found = json.loads(run(tmp_path / "a.wms", tmp_path / "b.wms", "--json").output)["diagnostics"]
    assert [(Path(d["file"]).name, d["code"]) for d in found] == [("a.wms", "WMS201"), ("b.wms", "WMS402")]


def test_a_check_waits_for_nothing_that_it_does_not_need() -> None:
    """Importing any of these takes longer than the check itself."""
    spec = ROOT / "specs/prediction/mechanistic/collide.wms"
    command = [sys.executable, "-X", "importtime", "-m", "wmspec", "check", "--no-cache", str(spec)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    imported = {line.rpartition("|")[2].strip().partition(".")[0] for line in done.stderr.splitlines()}
    assert "wmspec" in imported
    assert not imported & {"numpy", "pxr", "trimesh", "scipy", "pydantic", "PIL", "multiprocessing"}


def test_list_reports_groups_and_balance() -> None:
    gate = ROOT / "specs/gallery/gate.wms"
    plain, sizes = (CliRunner().invoke(main, ["list", *more, str(gate)]).output for more in ([], ["--sizes"]))
    assert "wide (2), tone (3 in 30), wood (2 in 30)" in plain
    assert "60: wide, aim, lane; 30: tone, wood" in sizes
    for reported in (plain, sizes):
        assert "balanced answers of `way`" in reported
        assert reported.endswith("300 instances in 60 groups\n")
