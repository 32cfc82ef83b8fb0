"""The audit of films: true futures are right, clips without a future answer nothing, and linear motion is reported."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from wmspec.dataset.audit.model import Finding
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.clips.audit import film_findings


def named(findings: list[Finding], words: str) -> Finding:
    (found,) = [finding for finding in findings if words in finding.what]
    return found


def test_baselines_score_as_they_should(films: Path) -> None:
    findings = film_findings(DatasetReader.open(films))
    assert {finding.task for finding in findings} == {"shove"}
    for name in ("oracle", "engine", "frozen", "blend"):
        assert named(findings, f"@{name}`").verdict == "holds", name
    assert named(findings, "something moves").verdict == "holds"
    # Without friction the ball keeps its velocity, so the question needs no physics.
    assert named(findings, "@linear`").verdict == "fails"


def test_a_damaged_film_fails(films: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(films, copy)
    for path in (copy / "films").glob("*/*/*.mkv"):
        path.write_bytes(b"no film")
    (finding,) = film_findings(DatasetReader.open(copy))
    assert finding.verdict == "fails"
    assert "damaged film" in finding.what


def test_a_dataset_without_films_has_no_findings(films: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    dataset = DatasetReader.open(films)
    monkeypatch.setitem(dataset.manifest, "film", None)
    assert film_findings(dataset) == []
