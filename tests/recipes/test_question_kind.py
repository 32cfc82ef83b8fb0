"""The recipe "adding a question kind", carried out on a copy: a module, and a row where kinds are distinguished."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq

from tests.engines import installed

ROOT = Path(__file__).parents[2]


def test_adding_a_question_kind(tmp_path: Path) -> None:
    """Open questions that are answered with a thing: which of them it is, is for the reader to say."""
    for engine in ("mujoco", "pybullet"):
        installed(engine)
    for part in ("wmspec", "backends", "grammar", "specs"):
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))

    _replace(tmp_path / "wmspec/lang/check/ir/ir.py", '"pictures", "possible"]', '"pictures", "possible", "names"]')
    rules = tmp_path / "wmspec/lang/check/statements/question_kinds.py"
    _replace(rules, '    "labels": QuestionRules(', RULES + '    "labels": QuestionRules(')
    _replace(rules, "import PICTURE,", "import OBJECT, PICTURE,")
    (tmp_path / "wmspec/runtime/questions/kinds/names.py").write_text(MODULE)
    kinds = tmp_path / "wmspec/runtime/questions/kinds/__init__.py"
    _replace(kinds, '"pictures": Pictures()', '"pictures": Pictures(), "names": Names()')
    _replace(kinds, "import Numbers\n", "import Numbers\nfrom wmspec.runtime.questions.kinds.names import Names\n")

    (tmp_path / "race.wms").write_text(SPEC)
    engines = ("-b", "mujoco,pybullet", "-j", "1")
    _wmspec(tmp_path, "generate", "race.wms", "-o", "out", "--size", "64", *engines)
    rows = pq.read_table(tmp_path / "out/data/race").to_pylist()
    found = sorted((r["answer_value"], r["answer"], r["option_text"]) for r in rows)
    assert found == [(words, None, []) for words in ("the blue cube", "the red sphere")]
    checked = json.loads(_wmspec(tmp_path, "crosscheck", "race.wms", "--json", "-", *engines))
    assert {v["kind"] for i in checked["instances"] for v in i["verdicts"]} == {"names"}
    assert [line["answers"] for line in checked["summary"]] == [{"good": 2, "all": 2}]


RULES = """    "names": QuestionRules(
        fits=lambda answer, clauses: answer == OBJECT and "options" not in clauses,
        spoken=True,
        refused=(_NO_COUNTERFACTUALS, _NO_TOLERANCE),
    ),
"""
MODULE = '''"""Open questions that are answered with a thing."""

from dataclasses import dataclass
from typing import ClassVar

from wmspec.runtime.questions.question_context import QuestionContext
from wmspec.runtime.questions.kinds.kind import Kind, in_words
from wmspec.runtime.questions.model import Answer
from wmspec.runtime.questions.runs import Run
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import QuestionKind


@dataclass(frozen=True)
class NameAnswer(Answer):
    """The thing's name in the spec."""

    kind: ClassVar[QuestionKind] = "names"
    name: str


class Names(Kind[NameAnswer]):
    """The answer is a thing."""

    def answer(self, asking: QuestionContext) -> NameAnswer:
        return NameAnswer(evaluate(asking.question.answer, asking.measured))

    def words(self, asking: QuestionContext, answer: NameAnswer) -> str:
        return in_words(asking, answer.name)

    def change_under_nudge(self, asking: QuestionContext, answer: NameAnswer, nudged: Run, by: float) -> str:
        now = evaluate(asking.question.answer, asking.measured_on(nudged))
        return "" if now == answer.name else f"{answer.name} becomes {now}"

    def agree(self, a: NameAnswer, b: NameAnswer) -> bool:
        return a == b

    def remedy(self, sort: str) -> str:
        return "ask for a larger margin"
'''
SPEC = """use tabletop
task race : custom {
  factor pace in [20, 5] cm/s
  object far  { shape: sphere  size: 8 cm  color: red   on: table at (-20 cm, 12 cm) }
  object near { shape: cube    size: 8 cm  color: blue  on: table at (-20 cm, -12 cm) }
  action a = glide(far, direction: 0 deg, speed: pace) for 0.5 s
  action b = glide(near, direction: 0 deg, speed: 10 cm/s) for 0.5 s
  observe front at [0 s, 0.5 s]
  question "Which is faster?" { answer fastest([far, near])  legibility off }
}
"""


def _replace(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert text.count(old) == 1, f"{old!r} in {path}"
    path.write_text(text.replace(old, new))


def _wmspec(folder: Path, *arguments: str) -> str:
    command = [sys.executable, "-m", "wmspec", *arguments]
    environment = {"PYTHONPATH": str(folder), "PATH": "/usr/bin:/bin"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout
