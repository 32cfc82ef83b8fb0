"""Latent models: surprises of futures, raw and centred."""

from __future__ import annotations

import csv
import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from wmspec.cli import main
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.clips.questions import FilmQuestion, film_questions
from wmspec.eval.clips.surprise import centred, choice
from wmspec.eval.models.question import Selection


@given(arrays(float, (4, 4), elements=st.floats(0, 100)), arrays(float, 4, elements=st.floats(-50, 50)))
def test_bias_of_a_future_is_removed(matrix: Any, bias: Any) -> None:
    assert np.allclose(centred(matrix + bias), centred(matrix), atol=1e-9)


def test_ties_and_unknown_values_are_no_answer() -> None:
    assert choice(np.array([2.0, 1.0, 3.0, 4.0])) == 1
    assert choice(np.array([1.0, 1.0, 3.0, 4.0])) is None
    assert choice(np.array([1.0, np.nan, 3.0, 4.0])) is None


@pytest.fixture
def model(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """A package of models: one that knows what follows, with a bias for each future, and one that knows nothing."""
    module = ModuleType("latent")

    def biased(context: Any, future: Any, fps: int, text: str) -> Any:
        # The right future alone begins near the last picture of the context; each future has a bias of its own.
        step = np.abs(future[0].astype(float) - context[-1]).mean()
        return step + 1000 * float(future[-1].astype(int).sum() % 997)

    def blind(context: Any, future: Any, fps: int, text: str) -> Any:
        return np.full(len(future), float(future[-1].astype(int).sum() % 997))

    module.biased, module.blind = biased, blind  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "latent", module)
    return module


def scored(films: Path, model: str, output: Path) -> list[dict[str, Any]]:
    result = CliRunner().invoke(main, ["evaluate", str(films), "-m", model, "-o", str(output)])
    assert result.exit_code == 0, result.output
    rows: list[dict[str, Any]] = pq.read_table(output).to_pylist()
    return rows


def test_a_constant_bias_is_wrong_raw_and_right_centred(films: Path, model: ModuleType, tmp_path: Path) -> None:
    rows = scored(films, "surprise:latent:biased", tmp_path / "r.parquet")
    raw, without = ([row for row in rows if row["prompt"] == name] for name in ("raw", "centred"))
    assert len(raw) == len(without) == 8
    assert sum(row["right"] for row in raw) == 2
    assert all(row["right"] for row in without)


def test_a_model_that_ignores_the_context_is_at_chance(films: Path, model: ModuleType, tmp_path: Path) -> None:
    rows = scored(films, "surprise:latent:blind", tmp_path / "r.parquet")
    assert sum(row["right"] for row in rows if row["prompt"] == "raw") == 2
    assert not any(row["right"] for row in rows if row["prompt"] == "centred")


def test_a_table_of_surprises(films: Path, tmp_path: Path) -> None:
    dataset = DatasetReader.open(films)
    questions: list[FilmQuestion] = list(film_questions(dataset, Selection().ids(dataset)))
    table = tmp_path / "s.csv"
    with table.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["id", "place", "frame", "surprise"])
        for question in questions:
            for place in range(4):
                for frame in range(2):
                    out.writerow([question.id, place, frame, (place != question.answer) + frame])
    assert all(row["right"] for row in scored(films, f"surprises:{table}", tmp_path / "r.parquet"))
    table.write_text("id,place,frame,surprise\nx,0,,much\n")
    result = CliRunner().invoke(
        main, ["evaluate", str(films), "-m", f"surprises:{table}", "-o", str(tmp_path / "q.parquet")]
    )
    assert result.exit_code == 2
    assert "s.csv:2" in result.output


@pytest.mark.parametrize("name", ["latent", "no.such.package:f", "math:nothing"])
def test_a_model_that_is_not_there(name: str, films: Path, tmp_path: Path) -> None:
    result = CliRunner().invoke(
        main, ["evaluate", str(films), "-m", f"surprise:{name}", "-o", str(tmp_path / "r.parquet")]
    )
    assert result.exit_code == 2
    assert name in result.output


def test_the_adapter_of_v_jepa_2() -> None:
    """A tiny model with random weights gives a number that depends on context and future."""
    pytest.importorskip("torch")
    transformers = pytest.importorskip("transformers")
    path = Path(__file__).parents[2] / "docs/adapters/vjepa2.py"
    spec = importlib.util.spec_from_file_location("vjepa2", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    sizes = {"hidden_size": 32, "num_hidden_layers": 2, "num_attention_heads": 2, "crop_size": 32, "patch_size": 16}
    more = {"pred_hidden_size": 16, "pred_num_hidden_layers": 1, "pred_num_attention_heads": 2, "frames_per_clip": 8}
    adapter = module.VJepa2(transformers.VJEPA2Model(transformers.VJEPA2Config(**sizes, **more)))
    random = np.random.default_rng(0)
    context, future = (random.integers(0, 256, (n, 40, 60, 3), dtype=np.uint8) for n in (3, 9))
    surprise = adapter(context, future, 12, "")
    assert surprise > 0
    assert adapter(context, future[::-1].copy(), 12, "") != surprise
