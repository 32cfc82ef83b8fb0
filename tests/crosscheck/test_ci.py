"""A crosscheck as continuous integration uses it: results kept by content, baselines, changes, limits and reports."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlparse
from xml.etree import ElementTree as ET

import pytest
from click.testing import CliRunner, Result

from tests.crosscheck.repository import PAIR, commit, git, make
from wmspec.api import Agreement, WmsError, crosscheck
from wmspec.cli import main
from wmspec.core.disk_cache import DiskCache
from wmspec.runtime.compare import result_cache
from wmspec.runtime.compare.baseline import Baseline, read_baseline


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    made = make(tmp_path / "repository")
    monkeypatch.chdir(made)
    monkeypatch.delenv("GITHUB_ACTIONS", raising=False)
    return made


def checked(*specs: str, **options: Any) -> Agreement:
    given: dict[str, Any] = {"backend": PAIR, "sample": 3, "workers": 0, "cache": "../cache"} | options
    return crosscheck(specs or ("specs",), **given)


def run(*arguments: str) -> Result:
    options = ("specs", "-b", PAIR, "-n", "3", "-j", "1", "--cache", "../cache")
    return CliRunner().invoke(main, ["crosscheck", *options, *arguments], catch_exceptions=False)


def entries() -> list[Path]:
    return sorted(Path("../cache/crosscheck").glob("*.json"))


# ---------------------------------------------------------------- results kept by content


def test_executed_episodes_are_reused(repository: Path) -> None:
    first, second = checked(), checked()
    assert (first.cached, second.cached, len(entries())) == (0, 6, 6)
    assert second.record() == first.record()
    assert second.junit() == first.junit()
    assert json.dumps(second.record()) == json.dumps(first.record())
    assert checked(sample=2).cached == len(checked(sample=2).instances)


def test_only_a_changed_spec_is_executed_again(repository: Path) -> None:
    checked()
    race, tumble = repository / "specs/race.wms", repository / "specs/tumble.wms"
    race.write_text(race.read_text().replace("horizon 0.6 s", "# a comment\n  horizon 0.6 s"))
    assert checked().cached == 6
    tumble.write_text(tumble.read_text().replace("horizon 2 s", "horizon 1.9 s").replace("0 s .. 2 s", "0 s .. 1.9 s"))
    assert checked().cached == 3
    plate = repository / "specs/plate.wms"
    plate.write_text(plate.read_text().replace("2 cm", "3 cm"))
    assert checked().cached == 3


@pytest.mark.parametrize(
    "change",
    [
        {"tolerance": ["drift=1cm/s"]},
        {"seed": 1},
        {"backend": "sapien,mujoco"},
        {"cache": "../other"},
        {"cache": False},
    ],
    ids=str,
)
def test_other_settings_are_another_content(repository: Path, change: dict[str, Any]) -> None:
    checked("specs/race.wms", sample=1)
    assert checked("specs/race.wms", sample=1, **change).cached == 0


@pytest.mark.parametrize("what", ["engine_version", "code_digest", "backend_digest"])
def test_another_version_executes_again(repository: Path, what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    checked("specs/race.wms", sample=1)
    assert checked("specs/race.wms", sample=1).cached == 1
    monkeypatch.setattr(result_cache, what, lambda *_: "another")
    assert checked("specs/race.wms", sample=1).cached == 0


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "of another instance", "writable by others", "a link"])
def test_a_damaged_or_foreign_entry_is_not_believed(repository: Path, damage: str) -> None:
    plain = checked("specs/race.wms", sample=2)
    first, second = entries()
    content = first.read_bytes()
    if damage == "cut":
        first.write_bytes(content[:-5])
    elif damage == "flipped":
        first.write_bytes(content[:99] + bytes([content[99] ^ 1]) + content[100:])
    elif damage == "empty":
        first.write_bytes(b"")
    elif damage == "of another instance":
        first.write_bytes(second.read_bytes())
    elif damage == "writable by others":
        first.chmod(0o666)
    else:
        first.rename("../elsewhere")
        first.symlink_to(Path("../elsewhere").resolve())
    again = checked("specs/race.wms", sample=2)
    assert (again.cached, again.refused) == (1, 0 if damage == "a link" else 1)
    assert again.record() == plain.record()
    assert checked("specs/race.wms", sample=2).cached == 2


def test_foreign_result_is_not_used(repository: Path) -> None:
    """Key and checksum are right: an entry of a version with other fields, or of another instance."""
    checked("specs/race.wms", sample=1)
    (entry,) = entries()
    store = DiskCache(entry.parent)
    record = json.loads(store.read(entry.name) or b"")
    wrong: object
    for wrong in ([], {}, record | {"result": "{}"}, record | {"result": record["result"].replace('"race"', '"rice"')}):
        store.write(entry.name, json.dumps(wrong).encode())
        again = checked("specs/race.wms", sample=1)
        assert (again.cached, again.refused) == (0, 1)


def test_named_files_belong_to_the_content_of_a_spec(repository: Path) -> None:
    mesh = repository / "specs/ramp.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    race = repository / "specs/race.wms"
    ramp = '  object ramp { file: "ramp.obj"  on: floor at (3 m, 3 m)  fixed: true }\n'
    race.write_text(race.read_text().replace("  object near", f"{ramp}  object near"))
    assert [checked("specs/race.wms", sample=1).cached for _ in range(2)] == [0, 1]
    (repository / "specs/notes.txt").write_text("no part of it")
    assert checked("specs/race.wms", sample=1).cached == 1
    mesh.write_text(mesh.read_text().replace("v 0 0 1", "v 0 0 2"))
    assert checked("specs/race.wms", sample=1).cached == 0


# ---------------------------------------------------------------- baselines


def test_a_known_disagreement_is_accepted_and_a_second_one_fails(repository: Path) -> None:
    missing = run("--baseline", "known.json")
    assert missing.exit_code == 2
    assert "--update-baseline" in missing.stderr
    found = run()
    assert found.exit_code == 1
    assert "mujoco answers the blue cube, sapien the red cube" in found.stdout
    assert "after touching `post_a`" in found.stdout
    accepted = run("--baseline", "known.json", "--update-baseline")
    assert accepted.exit_code == 0, accepted.stderr
    assert "1 known disagreements, 1 added, 0 removed" in accepted.stderr
    again = run("--baseline", "known.json", "--junit", "out.xml")
    assert again.exit_code == 0
    assert "with known disagreements" in again.stdout
    suites = ET.parse("out.xml").getroot().findall("testsuite")
    assert [(s.get("failures"), s.get("skipped")) for s in suites] == [("0", "0"), ("0", "1")]

    text = (repository / "specs/tumble.wms").read_text()
    (repository / "specs/other.wms").write_text(text.replace("task tumble :", "task other :"))
    failed = run("--baseline", "known.json")
    assert failed.exit_code == 1
    assert "\nother, instance" in failed.stdout
    assert "\ntumble, instance" not in failed.stdout


def test_a_vanished_disagreement_is_named_and_removed_on_request(repository: Path) -> None:
    before = checked().updated_baseline
    (known,) = before.known
    Path("known.json").write_text(before.text())
    assert read_baseline(Path("known.json"), 0).identities == before.identities
    agreement = checked(tolerance=["drift=1cm/s"], baseline="known.json")
    assert (agreement.new, agreement.vanished) == ((), ())
    spec = repository / "specs/tumble.wms"
    margin = "margin  speed(a) - speed(b) apart by 90 m/s\n    "
    spec.write_text(spec.read_text().replace("answer  fastest", f"{margin}answer  fastest"))
    gone = run("--baseline", "known.json")
    assert gone.exit_code == 0
    assert f"removes them from the baseline:\n  tumble, instance {known.index}" in gone.stdout
    partial = crosscheck("specs/race.wms", backend=PAIR, sample=1, workers=0, baseline="known.json")
    assert partial.vanished == ()
    assert partial.updated_baseline.identities == before.identities
    assert run("--baseline", "known.json", "--update-baseline").exit_code == 0
    assert read_baseline(Path("known.json"), 0) == Baseline(0)


@pytest.mark.parametrize(
    "content",
    [
        "",
        "[]",
        "{}",
        '{"format": 1, "seed": 0, "known": [{}]}',
        '{"format": 9}',
        '{"format": 1, "seed": 3, "known": []}',
        "\xff",
    ],
)
def test_invalid_baseline_is_an_error_with_its_file(tmp_path: Path, content: str) -> None:
    path = tmp_path / "known.json"
    path.write_text(content, encoding="latin-1")
    with pytest.raises(WmsError) as caught:
        read_baseline(path, 0)
    assert str(path) in str(caught.value)


# ---------------------------------------------------------------- changes and limits


def test_only_tasks_whose_files_changed_are_executed(repository: Path) -> None:
    def names(revision: str = "main") -> list[str]:
        return [task.name for task in checked(sample=1, changed_since=revision).tasks]

    git(repository, "checkout", "--quiet", "-b", "topic")
    assert names() == []
    plate = repository / "specs/plate.wms"
    plate.write_text(plate.read_text() + "# changed\n")
    assert names() == ["tumble"]
    commit(repository)
    assert names() == ["tumble"]
    git(repository, "checkout", "--quiet", "main")
    race = repository / "specs/race.wms"
    race.write_text(race.read_text() + "# changed on main\n")
    commit(repository)
    git(repository, "checkout", "--quiet", "topic")
    assert names() == ["tumble"]
    (repository / "specs/new.wms").write_text(race.read_text().replace("task race", "task new"))
    assert names() == ["new", "tumble"]
    with pytest.raises(WmsError, match="no commit of this name"):
        names("nowhere")
    with pytest.raises(WmsError, match="expected a git revision"):
        names("--output=x")


def test_without_changes_the_command_passes_and_writes_its_reports(repository: Path) -> None:
    reports = (
        "--junit",
        "out.xml",
        "--sarif",
        "out.sarif",
        "--json",
        "out.json",
        "--html",
        "out.html",
        "--gitlab",
        "out.gl",
    )
    done = run("--changed-since", "HEAD", *reports)
    assert (done.exit_code, done.stdout) == (0, "no task has changed since HEAD\n")
    assert json.loads(Path("out.sarif").read_text())["runs"][0]["results"] == []
    assert json.loads(Path("out.json").read_text())["passes"]
    assert json.loads(Path("out.gl").read_text()) == []
    assert ET.parse("out.xml").getroot().findall("testsuite") == []
    assert "There are no disagreements." in Path("out.html").read_text()


def test_outside_of_a_repository_git_gives_the_reason(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make(tmp_path / "made")
    (tmp_path / "made/.git").rename(tmp_path / "gone")
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path))
    with pytest.raises(WmsError, match=r"--changed-since: git fails in .*not a git repository"):
        crosscheck(tmp_path / "made/specs", backend=PAIR, changed_since="main")


def test_a_share_of_failures_is_permitted(repository: Path) -> None:
    agreement = checked()
    assert (len(agreement.failed), round(agreement.share, 1)) == (1, 83.3)
    assert not agreement.passed
    assert run("--fail-under", "80").exit_code == 0
    assert run("--fail-under", "90").exit_code == 1


def test_time_limits_the_instances_to_the_first_ones(repository: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from wmspec.runtime.compare import sweep

    every = checked(cache=False).instances
    for groups in (1, 2, 4):
        ticks = iter([0.0] * groups + [10.0] * 99)
        monkeypatch.setattr(sweep, "monotonic", lambda ticks=ticks: next(ticks))
        monkeypatch.setattr("wmspec.api.agreement.monotonic", lambda: 0.0)
        agreement = checked(max_time=5.0, cache=False)
        assert len(agreement.instances) == groups
        assert agreement.planned == 6
        assert all(instance in every for instance in agreement.instances)
        assert {c.task for c in agreement.instances} == ({"race"} if groups == 1 else {"race", "tumble"})


@pytest.mark.parametrize("text", ["", "5", "90s", "5m", "1.5h"])
def test_times(text: str) -> None:
    from wmspec.cli.crosscheck import parse_time

    if not text:
        with pytest.raises(WmsError, match="expected a time"):
            parse_time("5 fortnights")
    else:
        assert parse_time(text) == {"5": 5, "90s": 90, "5m": 300, "1.5h": 5400}[text]


def test_a_broken_spec_is_a_clear_error(repository: Path) -> None:
    spec = repository / "specs/race.wms"
    spec.write_text(spec.read_text().replace("fastest([near, far])", "fastest([near, fare])"))
    done = run()
    assert done.exit_code == 2
    assert "specs/race.wms:19" in done.stderr
    assert "did you mean `far`?" in done.stderr


# ---------------------------------------------------------------- reports


def test_reports_point_to_the_question_in_files_that_exist(repository: Path) -> None:
    reports = ("--sarif", "out.sarif", "--gitlab", "out.gl", "--annotations", "github")
    done = run(*reports)
    (annotation,) = (line for line in done.stdout.splitlines() if line.startswith("::"))
    assert annotation.startswith("::error title=wmspec crosscheck-answers,file=specs/tumble.wms,line=")
    (found,) = json.loads(Path("out.sarif").read_text())["runs"]
    (result,) = found["results"]
    place = result["locations"][0]["physicalLocation"]
    base = found["originalUriBaseIds"][place["artifactLocation"]["uriBaseId"]]["uri"]
    path = Path(unquote(urlparse(base + place["artifactLocation"]["uri"]).path))
    assert path == repository / "specs/tumble.wms"
    assert "question" in path.read_text().splitlines()[place["region"]["startLine"] - 1]
    assert "mujoco answers the blue cube" in result["message"]["text"]
    (issue,) = json.loads(Path("out.gl").read_text())
    assert issue["location"]["path"] == "specs/tumble.wms"
    assert set(issue) == {"description", "check_name", "fingerprint", "severity", "location"}


@pytest.mark.parametrize("form", ["github", "gitlab", "sarif"])
def test_diagnostics_of_a_check_have_paths_of_the_repository(
    repository: Path, form: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also those in libraries, and from a folder below the root."""
    monkeypatch.chdir(repository / "specs")
    plate = repository / "specs/plate.wms"
    plate.write_text(plate.read_text().replace("shape: box", "shape: bax"))
    done = CliRunner().invoke(main, ["check", "--format", form, "tumble.wms", "plate.wms"])
    assert done.exit_code == 2
    if form == "github":
        assert "file=specs/plate.wms,line=4" in done.stdout
    elif form == "gitlab":
        assert {issue["location"]["path"] for issue in json.loads(done.stdout)} == {"specs/plate.wms"}
    else:
        (found,) = json.loads(done.stdout)["runs"]
        uris = {r["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] for r in found["results"]}
        assert uris == {"specs/plate.wms"}


@pytest.mark.pixels
def test_the_page_shows_both_engines(repository: Path, browser: Any) -> None:
    from tests.browser import barriers, opened

    assert run("--html", "out.html").exit_code == 1
    for tab in opened(browser, Path("out.html").resolve()):
        assert tab.locator("article").count() == 1
        assert tab.locator("img").count() == 6
        widths = tab.evaluate("[...document.images].map(image => image.naturalWidth)")
        assert widths == [320] * 6
        assert tab.locator("svg polyline.engine0").count() >= 1
        assert tab.locator("svg polyline.engine1").count() >= 1
        assert "mujoco answers the blue cube" in tab.locator("article").inner_text()
        assert barriers(tab) == []
