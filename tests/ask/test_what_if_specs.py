"""Paradigms that need hidden things, what-ifs, sets of actions and conditions: their specs keep their instances."""

from pathlib import Path

import pytest

from tests.ask.asking import pair
from tests.engines import ENGINES
from tests.language.specs import task_of
from wmspec.compile.design.design import Design
from wmspec.compile.lint.dry_run import dry_run
from wmspec.core.diagnostics import Report
from wmspec.runtime.questions.ask import ask
from wmspec.runtime.questions.cross_validation import CrossValidation
from wmspec.runtime.questions.model import QuestionRow, Rejected

ROOT = Path(__file__).parents[2]
SPECS = sorted((ROOT / "tests/data/rewritten").glob("*.wms"))
#: Those of many pictures are tested where slow tests run.
QUICK = [pytest.param(p, marks=pytest.mark.slow) if p.stem in {"nav_memory", "shell"} else p for p in SPECS]
#: Instances of a quick test, and of one in all engines; the share of them that is kept at least.
FEW, MANY, LEAST = 1, 10, 0.9


@pytest.mark.parametrize("path", QUICK, ids=lambda path: path.stem)
def test_spec_has_no_mistakes_and_keeps_its_questions(path: Path) -> None:
    spec, report = task_of(path), Report()
    dry_run(spec, report)
    assert report.diagnostics == ()
    design, engines = Design(spec), pair("mujoco", 128)
    rows = [row for index in design.sample(FEW) for row in ask(design, index, engines)]
    assert [row for row in rows if isinstance(row, Rejected)] == []


@pytest.mark.slow
@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_engines_agree_on_nearly_all_instances(path: Path) -> None:
    design, pairs = Design(task_of(path)), {engine: pair(engine, 256) for engine in ENGINES}
    rows = [row for index in design.sample(MANY) for row in CrossValidation(design, index, pairs, "all").questions()]
    assert sum(isinstance(row, QuestionRow) for row in rows) >= LEAST * len(rows)
