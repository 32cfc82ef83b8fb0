"""Sheets for readers tell no truth, and what readers answer is scored by task and tier."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from tests.dataset.made import make, plan
from tools import readings
from wmspec.dataset.build.reader import DatasetReader


def written(folder: Path) -> tuple[Path, dict[str, dict[str, object]]]:
    make(folder / "made", plan(count=8))
    readings.sheets(DatasetReader.open(folder / "made"), 4, folder / "sheets", folder / "keys")
    files = sorted((folder / "keys").glob("*.json"))
    return folder / "sheets", {name: key for file in files for name, key in json.loads(file.read_text()).items()}


def test_every_question_is_on_a_sheet_and_in_the_key_and_no_truth_beside_it(tmp_path: Path) -> None:
    folder, keys = written(tmp_path)
    for task in ("collide", "motion_speed"):
        text = (folder / task / "questions.txt").read_text()
        asked = [name for name, key in keys.items() if key["task"] == task]
        assert len(asked) == 4
        assert all(f"{name}: " in text for name in asked)
        assert "truth" not in text
        assert "counterfactual" not in text
        sheets = sorted((folder / task).glob("*.png"))
        assert len(sheets) == 2
        with Image.open(sheets[0]) as sheet:
            assert sheet.width == readings.WIDTH


@given(blocks=st.lists(st.integers(0, 5), max_size=40), readers=st.integers(1, 5))
def test_siblings_go_to_different_readers_while_there_are_any(blocks: list[int], readers: int) -> None:
    rows: list[dict[str, Any]] = [{"question": 0, "block": block, "id": str(i)} for i, block in enumerate(blocks)]
    hands = readings.dealt(rows, readers)
    assert sorted(row["id"] for hand in hands for row in hand) == sorted(row["id"] for row in rows)
    for block in set(blocks):
        held = [sum(row["block"] == block for row in hand) for hand in hands]
        assert max(held) - min(held) <= 1


def test_scores_count_what_is_right(tmp_path: Path) -> None:
    _, keys = written(tmp_path)
    answers = {name: str(key["answer"]) for name, key in keys.items() if key["task"] == "collide"}
    wrong = next(iter(answers))
    answers[wrong] = "A" if answers[wrong] == "B" else "B"
    (line,) = [line for line in readings.scored(keys, [answers]) if "collide" in line]
    assert "3/4" in line
    with pytest.raises(ValueError, match="to no question"):
        list(readings.scored(keys, [{"collide/999999/q0": "A"}]))
