"""`wmspec crosscheck` as a user types it: engines that agree pass, chaos is explained and fails."""

import json
import subprocess
import sys
from dataclasses import replace
from itertools import islice
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.lang.check.ir.ir import QuestionKind
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.compare.check import check
from wmspec.runtime.compare.model import CheckResult, Verdict
from wmspec.runtime.compare.summary import Share, lines, suspects, unreliable_answers
from wmspec.runtime.compare.tolerance import Tolerances
from wmspec.runtime.compare.verbalize import dispute

HERE = Path(__file__).parent
PAIR = ("mujoco", "sapien")


def crosscheck(*arguments: str, code: int) -> str:
    command = [sys.executable, "-c", "from wmspec.cli import main; main()", "crosscheck", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, cwd=HERE, timeout=300, check=False)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout if code != 2 else done.stderr


def checked(text: str, count: int = 1, **levels: float) -> list[CheckResult]:
    """The first instances, or those of the given levels."""
    design = Design(task_from(text))
    executors = [TraceCache(engine) for engine in PAIR]
    expected = (i.index for i in design if levels.items() <= i.factors.items())
    return [check(design, i, executors, Tolerances()) for i in islice(expected, count)]


def test_engines_that_agree_pass(tmp_path: Path) -> None:
    junit = tmp_path / "junit.xml"
    found = json.loads(
        crosscheck("race.wms", "-n", "2", "-j", "1", "--strict", "--json", "-", "--junit", str(junit), code=0)
    )
    assert found["passes"]
    assert [s["answers"] for s in found["summary"]] == [{"good": 2, "all": 2}] * 3
    assert all(c["within"] for i in found["instances"] for c in i["comparisons"])
    suite = ET.parse(junit).getroot().find("testsuite")
    assert suite is not None
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("2", "0", "0")


def test_chaos_is_explained_and_fails(tmp_path: Path) -> None:
    junit = tmp_path / "junit.xml"
    said = crosscheck("tumble.wms", "-b", "mujoco,sapien", "-j", "1", "--junit", str(junit), code=1)
    assert "0/3" in said
    assert "mujoco answers the blue cube, sapien the red cube" in said
    assert "after touching `post_a`" in said
    assert "restitution 0.9" in said
    assert "bounces on edges are chaotic" in said
    failures = ET.parse(junit).getroot().findall("testsuite/testcase/failure")
    assert failures
    assert all(f.get("type") == "answers" and "`post_a`" in (f.text or "") for f in failures)


def test_answers_that_depend_on_engine_faults_are_marked() -> None:
    found = checked((HERE / "row.wms").read_text())
    row, roll = unreliable_answers(found)
    assert (row.answers, roll.answers) == (Share(1, 1), Share(1, 1))
    assert "`a` and `b` meet" in row.where
    assert "`b` already touches `c`" in row.where
    assert "`can` rolls" in roll.where
    assert not unreliable_answers(checked((HERE / "race.wms").read_text()))


def test_a_question_that_no_engine_would_ask_does_not_fail() -> None:
    text = (HERE / "tumble.wms").read_text()
    gated = text.replace(
        "answer  fastest([a, b])", "answer  fastest([a, b])\n    margin  speed(a) - speed(b) apart by 90 m/s"
    )
    assert gated != text
    (found,) = checked(gated, speed=2)
    (verdict,) = found.verdicts
    assert not verdict.agree
    assert not verdict.is_accepted
    assert found.passes(strict=False)
    assert not found.passes(strict=True)
    (line,) = lines([found], [PAIR])
    assert (line.answers, line.before_gates) == (Share(0, 0), Share(0, 1))


def test_without_questions_trajectories_decide() -> None:
    text = (HERE / "tumble.wms").read_text()
    (found,) = checked(text[: text.index("question")] + "}\n")
    assert not found.verdicts
    assert not found.passes(strict=False)


def test_pictures_are_compared_with_the_counterfactuals_of_the_other_engine() -> None:
    text = (HERE / "race.wms").read_text()
    questions = """question "What comes next?" {
      answer frame(front, end)
      counterfactual slower { action go_near.speed: 0.2 m/s }
      distinct by 2 cm
    }\n}\n"""
    (found,) = checked(text[: text.index("question")] + questions)
    assert [c.run for c in found.comparisons] == ["truth", "slower"]
    (verdict,) = found.verdicts
    assert verdict.agree
    assert verdict.is_accepted
    assert found.passes(strict=True)


def test_a_picture_after_the_end_is_no_answer() -> None:
    text = (HERE / "race.wms").read_text()
    questions = """question "Then?" {
      answer frame(front, onset(near) + 60 s)  counterfactual slower { action go_near.speed: 0.2 m/s } }\n}\n"""
    (found,) = checked(text[: text.index("question")] + questions)
    assert all(r and "s is outside the episode" in r for r in found.verdicts[0].rejected)


def test_failed_execution_has_its_reason() -> None:
    text = (HERE / "race.wms").read_text().replace("size: 10 cm  color: red", "size: (ratio - 1.5) * 10 cm  color: red")
    (found,) = checked(text, ratio=1.5)
    assert not found.passes(strict=False)
    assert "`size` of `near` is 0 cm here" in found.failures[0].reason


@pytest.mark.parametrize(
    ("kind", "sort", "remedy"),
    [
        ("labels", "truth value", "on the brink"),
        ("labels", "relation", "on the brink"),
        ("labels", "object", "larger margin"),
        ("numbers", "speed", "larger margin"),
        ("pictures", "picture", "`distinct by`"),
    ],
)
def test_without_a_cause_the_remedy_suits_the_answer(kind: QuestionKind, sort: str, remedy: str) -> None:
    said = dispute(
        Verdict(0, kind, sort, PAIR, ("yes", "no"), (None, None), False, "yes in one, no in the other", None)
    )
    assert remedy in said
    assert ("use a larger margin" in said) == (remedy == "larger margin")


def test_the_factor_at_fault_is_named() -> None:
    (good,) = checked((HERE / "race.wms").read_text())
    far = replace(good, factors=good.factors | {"faster": "far"})
    gaps = [replace(c, gaps=tuple(replace(g, began=0.1) for g in c.gaps)) for c in good.comparisons]
    parted = replace(far, comparisons=tuple(gaps))
    (found,) = suspects([good, good, far, parted, parted])
    assert (found.what, found.factor, found.value) == ("trajectories part", "faster", "far")
    assert (found.with_it, found.without) == (Share(2, 3), Share(0, 2))


@pytest.mark.parametrize(
    ("arguments", "remedy"),
    [
        (("race.wms", "-b", "mujoco"), "needs two engines"),
        (("race.wms", "-b", "mujoco,bullet"), "did you mean `pybullet`?"),
        (("race.wms", "-t", "drift=3"), "expected a speed, such as drift=1cm/s"),
        (("nowhere.wms",), "nowhere.wms"),
    ],
)
def test_mistake_is_reported_with_its_remedy(arguments: tuple[str, ...], remedy: str) -> None:
    assert remedy in crosscheck(*arguments, code=2)


@pytest.mark.slow
def test_the_number_of_workers_changes_nothing(tmp_path: Path) -> None:
    files = []
    for workers in ("1", "2"):
        files.append((tmp_path / f"{workers}.json", tmp_path / f"{workers}.xml"))
        paths = ("--json", str(files[-1][0]), "--junit", str(files[-1][1]))
        crosscheck("tumble.wms", "race.wms", "-j", workers, *paths, code=1)
    assert [f.read_bytes() for f in files[0]] == [f.read_bytes() for f in files[1]]


def test_the_tolerances_of_a_spec_are_those_of_its_task(tmp_path: Path) -> None:
    text = (HERE / "race.wms").read_text()
    spec = tmp_path / "race.wms"
    spec.write_text(
        text.replace("  horizon 0.6 s", "  tolerance drift 2 cm/s\n  tolerance event 30 ms\n  horizon 0.6 s")
    )
    arguments = [str(spec), "-b", "mujoco,pybullet", "-n", "1", "-j", "1", "-t", "event=5ms", "--json", "-"]
    limits = json.loads(crosscheck(*arguments, code=0))["tolerances"]["race"]
    assert (limits["drift"], limits["event"], limits["rest"]) == (0.02, 0.005, Tolerances().rest)
