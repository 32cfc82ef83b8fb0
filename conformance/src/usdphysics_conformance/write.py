"""The cases as files, for engines to execute."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from usdphysics_conformance.case import SAMPLE_RATE, Case


def write_cases(folder: Path, cases: Iterable[Case]) -> None:
    """Writes the stage of each case as CASE.usda, and cases.json: stages, durations (s) and sample rates (Hz)."""
    folder.mkdir(parents=True, exist_ok=True)
    index = {}
    for case in cases:
        stage = f"{case.name}.usda"
        (folder / stage).write_text(case.stage, encoding="utf-8")
        index[case.name] = {"stage": stage, "seconds": case.seconds, "rate": SAMPLE_RATE}
    (folder / "cases.json").write_text(json.dumps(index, indent=2) + "\n", encoding="utf-8")
