"""The examples of the language pages are checked and formatted, and the reference pages are current."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.language.specs import SPECS
from tests.language.test_format import without_places
from wmspec.compile.lint.dry_run import dry_run
from wmspec.core.diagnostics import Report
from wmspec.core.places import Source
from wmspec.editor.start import first_spec
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.ir.record import plain
from wmspec.lang.check.statements.dimensions import DIMENSIONS
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.check.tables.vocabulary import (
    CONDITIONAL_DOMAINS,
    CONTINUOUS_DOMAINS,
    DESIGNS,
    FACTOR_DOMAINS,
    WEIGHTED_DOMAINS,
    DesignForm,
    SyntaxForm,
)
from wmspec.lang.parse.files import read_source
from wmspec.lang.parse.format import format_spec
from wmspec.lang.parse.load import load_source
from wmspec.lang.parse.parser import parse
from wmspec.lang.parse.syntax import Task

ROOT = Path(__file__).parents[2]
PAGE_PATH = ROOT / "docs/language.md"
PAGE = PAGE_PATH.read_text()
FIRST_TASK = (ROOT / "docs/get_started/first_task.md").read_text()
IN_PYTHON = (ROOT / "docs/guides/specs_in_python.md").read_text()
GUIDES = [path.read_text() for path in sorted((ROOT / "docs/guides").glob("*.md"))]


def examples(page: str) -> list[str]:
    return re.findall(r"^```wms(?: \w+)?\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)


EXAMPLES = [
    text for page in (PAGE, FIRST_TASK, (ROOT / "docs/index.md").read_text(), *GUIDES) for text in examples(page)
]


def test_every_dimension_of_the_catalogue_is_a_known_one() -> None:
    for path in SPECS:
        tasks = (item for item in parse(read_source(path), Report()).items if isinstance(item, Task))
        for names in ([n.id for n in task.path] for task in tasks):
            for i, name in enumerate(names):
                assert name in DIMENSIONS[".".join(names[:i])].split(), path


def tasks_in(text: str) -> list[tuple[TaskSpec, int]]:
    report = Report()
    tasks = check_program(load_source(Source(str(PAGE_PATH), text), ROOT, report), report)
    designs = [(task, dry_run(task, report)) for task in tasks]
    assert report.diagnostics == ()
    return [(task, len(design)) for task, design in designs if design is not None]


@pytest.mark.parametrize("text", EXAMPLES, ids=lambda t: t.strip().split("\n")[0][:20])
def test_examples_have_no_mistakes_and_are_formatted(text: str) -> None:
    tasks_in(text)
    assert format_spec(Source("docs", text)) == text


SCENE = """use tabletop
task t : custom {{
  factor shape in [cube, sphere]
  {}
  factor speed in [0.5, 1, 2] m/s
  object a {{ shape: shape  on: table }}
  action go = launch(a, direction: left, speed: speed)
  observe front at [0 s, 1 s]
}}
"""


@pytest.mark.parametrize(
    "form", [*FACTOR_DOMAINS, *CONDITIONAL_DOMAINS, *CONTINUOUS_DOMAINS, *WEIGHTED_DOMAINS], ids=lambda f: f.written
)
def test_the_tables_of_domains_are_what_factors_and_nuisances_take(form: SyntaxForm) -> None:
    """What a factor takes, a nuisance takes; the rest is refused with a remedy."""
    spread = form in CONTINUOUS_DOMAINS
    assert codes(f"nuisance x in {form.written}") == ({"WMS407"} if form in CONDITIONAL_DOMAINS else set())
    assert codes(f"factor x in {form.written}") == ({"WMS401"} if spread or form in WEIGHTED_DOMAINS else set())
    assert codes(f"factor x in {form.written}  design latin of 20") == (
        {"WMS401"} if form in WEIGHTED_DOMAINS else set()
    )


@pytest.mark.parametrize("plan", DESIGNS.values(), ids=lambda p: p.written)
def test_the_table_of_designs_is_what_is_taken(plan: DesignForm) -> None:
    assert codes(f"factor x in 1 .. 200 by 1  factor y in [1, 2]  {plan.written}") == set()


def codes(statements: str) -> set[str]:
    """The codes of the errors in a scene with these statements."""
    report = Report()
    for task in check_program(load_source(Source("forms", SCENE.format(statements)), ROOT, report), report):
        dry_run(task, report)
    return {d.code for d in report.diagnostics if d.severity == "error"}


def test_first_example_prints_as_documented() -> None:
    ((task, count),) = tasks_in(EXAMPLES[0])
    assert f"{task.name}: {count:,} instances, no mistakes\n" in PAGE


def test_the_spec_of_the_tutorial_is_that_of_the_template() -> None:
    (shown,) = examples(FIRST_TASK)
    assert shown == first_spec("marbles", "prediction")
    ((task, count),) = tasks_in(shown)
    assert f"{task.name}: {count} instances, no mistakes\n" in FIRST_TASK


def test_a_task_made_in_python_is_the_one_written_as_text() -> None:
    (code,) = re.findall(r"^```python\n(.*?)^```$", IN_PYTHON, re.MULTILINE | re.DOTALL)
    names: dict[str, Any] = {}
    exec(code, names)
    ((written, _),) = tasks_in(examples(IN_PYTHON)[-1])
    made = plain(names["roll"])
    assert without_places(made) == without_places(plain(written))


def test_the_tables_are_current() -> None:
    """If they are not: `make generate`."""
    assert subprocess.run([sys.executable, ROOT / "tools/reference.py", "--check"], check=False).returncode == 0
