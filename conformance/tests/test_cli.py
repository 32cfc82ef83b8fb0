"""The command line: its output, its exit codes and its errors."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from usdphysics_conformance import all_cases
from usdphysics_conformance.cli import main

DATA = Path(__file__).parent / "data"


def run(*arguments: str | Path) -> int:
    """The exit code of a command."""
    with pytest.raises(SystemExit) as exit_:
        main([*map(str, arguments)])
    return int(exit_.value.code or 0)


def test_cases_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("list") == 0
    assert sum(not line.startswith(" ") for line in capsys.readouterr().out.splitlines()) == len(all_cases())
    assert run("list", "free_fall", "--json") == 0
    (case,) = json.loads(capsys.readouterr().out)
    assert (case["case"], case["seconds"], case["bodies"]) == ("free_fall", 1.0, ["/World/ball"])


def test_stages_are_written_with_an_index(tmp_path: Path) -> None:
    assert run("write", tmp_path / "new/stages") == 0
    index = json.loads((tmp_path / "new/stages/cases.json").read_text())
    assert list(index) == list(all_cases())
    for name, about in index.items():
        assert about["rate"] == 240
        assert (tmp_path / "new/stages" / about["stage"]).read_text() == all_cases()[name].stage


def test_scores_and_their_card(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = ["--case", "free_fall", "--case", "collide_equal"]
    assert run("score", f"mujoco={DATA / 'mujoco'}", *good) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "mujoco: 3 of 3"
    assert run("score", f"mujoco={DATA / 'mujoco'}", *good, "--case", "cradle_touching") == 1
    assert capsys.readouterr().out.splitlines()[-1] == "mujoco: 3 of 8"
    assert run("score", f"mujoco={DATA / 'mujoco'}", *good, "--json") == 0
    (tmp_path / "scores.json").write_text(capsys.readouterr().out)
    assert run("card", tmp_path / "scores.json") == 0
    head = "| case | measured quantity | exact answer | tolerance | unit | mujoco |\n|---|"
    assert capsys.readouterr().out.startswith(head)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["list", "freefall"], "did you mean `free_fall`"),
        (["score", "traces"], "expected a name and a folder"),
        (["score", "mine=nowhere"], "nowhere: there is no such folder of traces"),
        (["card", "nothing.json"], "nothing.json: No such file"),
        (["card", "text.json"], "text.json: not JSON"),
        (["card", "list.json"], "list.json: not what `usdphysics-conformance score --json` prints"),
        (["write", "text.json"], "text.json: File exists"),
    ],
)
def test_a_mistake_is_one_line_with_exit_code_2(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("text.json").write_text("text")
    Path("list.json").write_text('[{"engine": "mine"}]')
    assert run(*arguments) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
