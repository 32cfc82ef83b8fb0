"""Every code has a page whose wrong example gives that code and nothing else, and whose right one gives nothing."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from wmspec.cli import main
from wmspec.compile.lint.dry_run import dry_run
from wmspec.core.diagnostics import Report
from wmspec.lang.check.statements.task import check
from wmspec.lang.parse.codes import CODES
from wmspec.lang.parse.pages import Example, page

FOLDER = Path(__file__).parents[2] / "wmspec/lang/parse/codes"


def codes(example: Example, folder: Path) -> set[str]:
    folder.mkdir()
    for name, text in (example.libraries | {"spec.wms": example.text}).items():
        (folder / name).write_text(text)
    report = Report()
    for spec in check(folder / "spec.wms", report):
        dry_run(spec, report)
    return {d.code for d in report.diagnostics}


@pytest.mark.parametrize("code", CODES)
def test_examples_do_what_they_say(code: str, tmp_path: Path) -> None:
    shown = page(code)
    assert shown.title == CODES[code]
    assert shown.markdown.startswith(f"# {code}: ")
    assert "## How to fix it" in shown.markdown
    assert codes(shown.wrong, tmp_path / "wrong") == {code}
    assert codes(shown.right, tmp_path / "right") == set()


def test_there_is_no_page_without_a_code() -> None:
    assert {file.stem for file in FOLDER.glob("*.md")} == set(CODES)


def test_the_command_shows_one_page_or_lists_all() -> None:
    run = CliRunner().invoke
    assert "unknown property" in run(main, ["explain", "wms203"]).output
    assert "unknown property" in run(main, ["explain", "203"]).output
    assert all(code in run(main, ["explain"]).output for code in CODES)


def test_unknown_code_suggests_similar_ones() -> None:
    result = CliRunner().invoke(main, ["explain", "WMS2003"])
    assert result.exit_code == 2
    assert "there are WMS201, WMS202, WMS203" in result.output
