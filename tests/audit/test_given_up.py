"""Four designs of ours that were given up, because one picture or two give the answer away: the audit fails them."""

from __future__ import annotations

from pathlib import Path

import pytest

import wmspec
from wmspec.dataset.audit.audit import audit

DATA = Path(__file__).parent / "data"


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.pixels
@pytest.mark.parametrize(
    ("name", "sees"),
    [
        ("trajectory_room", "picture"),
        ("trajectory_tabletop", "picture"),
        ("duration_tabletop", "pair"),
        ("color_tabletop", "picture"),
    ],
)
def test_a_design_that_gives_its_answer_away_fails(name: str, sees: str, tmp_path: Path) -> None:
    wmspec.generate(DATA / f"{name}.wms", tmp_path / name, backend="mujoco", per_task=200, size=96, workers=0)
    found = audit(tmp_path / name, 200, lambda task, count: None)
    assert found.summaries[0].verdict == "fails"
    assert "shortcut" in found.summaries[0].why
    telling = [p for p in found.probes if p.family == sees and p.judged and not p.luck]
    assert max(p.accuracy - p.chance for p in telling) > 0.2
