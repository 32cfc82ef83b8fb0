"""The audit fails earlier versions of five tasks, each for the defect that it had (tests/data/audit_old)."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.shared import Shared
from wmspec.dataset.audit.audit import audit
from wmspec.dataset.audit.model import Audit

OLD = Path(__file__).parent.parent / "data/audit_old"


def found(shared: Shared, task: str) -> Audit:
    return shared.value(f"audit/old/{task}", lambda: audit(OLD / task, 2000, lambda task, count: None))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("task", "check", "words"),
    [
        ("support", "shortcut", "from `lead` and the distance of the objects from the last picture (the best rule)"),
        ("support", "companions", "no companion question concerns `way`"),
        ("support", "motion", "something moves 12 px or more"),
        ("support", "metadata", "level of `way` depends on index modulo 2"),
        ("collide", "motion", "something moves 12 px or more"),
        ("collide", "companions", "no companion question concerns `pace`"),
        ("collide", "metadata", "level of `fill` depends on index modulo 4"),
        ("identification_room", "motion", "something moves 12 px or more"),
        ("identification_room", "metadata", "answer depends on "),
        ("relation_room", "metadata", "answer depends on index modulo 4"),
        ("material_room", "vocabulary", "`planks` is a kind of `wood`"),
        ("material_room", "metadata", "answer depends on order of the rows modulo 2"),
    ],
)
def test_an_old_task_fails_for_its_defect(task: str, check: str, words: str, shared: Shared) -> None:
    result = found(shared, task)
    (summary,) = result.summaries
    assert summary.verdict == "fails"
    assert check in summary.why
    assert any(f.check == check and f.verdict == "fails" and words in f.what for f in result.findings)


@pytest.mark.slow
def test_state_alone_leaves_chance_in_the_old_tasks(shared: Shared) -> None:
    """The sets of options were closed: nothing but the rules decides."""
    alone = [p for p in found(shared, "support").probes if p.sees in ("`lead`", "`way`")]
    assert [(p.accuracy, p.chance) for p in alone] == [(0.5, 0.5)] * 2
