"""The language reference tells the truth: its examples are executed and its tables are those of the implementation."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.language.test_format import without_places
from wmspec.check.ir import TaskSpec
from wmspec.check.task import check_program
from wmspec.parse.diagnostics import Report
from wmspec.parse.format import format_spec
from wmspec.parse.load import load_source
from wmspec.parse.source import Source
from wmspec.stage.trial import trial

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/language.md").read_text()
EXAMPLES = re.findall(r"^```wms(?: \w+)?\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def tasks_in(text: str) -> list[tuple[TaskSpec, int]]:
    report = Report()
    found = [
        (task, trial(task, report)) for task in check_program(load_source(Source("docs", text), ROOT, report), report)
    ]
    assert report.diagnostics == ()
    return found


@pytest.mark.parametrize("text", EXAMPLES, ids=lambda t: t.strip().split("\n")[0][:20])
def test_examples_have_no_mistakes_and_are_formatted(text: str) -> None:
    tasks_in(text)
    assert format_spec(Source("docs", text)) == text


def test_what_the_first_example_is_said_to_print() -> None:
    ((task, count),) = tasks_in(EXAMPLES[0])
    assert f"{task.name}: {count:,} instances, no mistakes\n" in PAGE


def test_a_task_made_in_python_is_the_one_written_as_text() -> None:
    (code,) = re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    names: dict[str, Any] = {}
    exec(code, names)
    ((written, _),) = tasks_in(EXAMPLES[-1])
    made = names["roll"].model_dump()
    assert without_places(made) == without_places(written.model_dump())


def test_the_tables_are_current() -> None:
    """If they are not: `python tools/reference.py`."""
    assert subprocess.run([sys.executable, ROOT / "tools/reference.py", "--check"], check=False).returncode == 0
