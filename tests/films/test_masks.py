"""Masks of a model in the place of masks by colour."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner

from wmspec.cli import main
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.clips.decide import decide
from wmspec.eval.clips.measure import measure
from wmspec.eval.clips.questions import film_questions, reference_of
from wmspec.eval.clips.read import Clip
from wmspec.eval.clips.run import ClipRun, evaluate_clips
from wmspec.eval.clips.sam2 import open_tracker
from wmspec.eval.models.question import Selection


def test_clips_are_measured_by_the_masks_of_a_tracker(films: Path) -> None:
    """With a tracker that knows the true masks, a future has its own points, and is recognized."""
    dataset = DatasetReader.open(films)
    question = next(iter(film_questions(dataset, Selection().ids(dataset))))
    plain = reference_of(dataset, question)

    def true_masks(frames: Any, masks: Any) -> Any:
        gaps = [np.abs(frames[1:].astype(int) - future).sum() for future in plain.futures]
        film = plain.films[int(np.argmin(gaps))]
        later = np.stack([film.ids[film.context :] == body for body in plain.objects])
        return np.concatenate([masks[:, None], later], axis=1)

    reference = reference_of(dataset, question, true_masks)
    for option, frames in enumerate(reference.futures):
        times = np.arange(len(frames)) / reference.rate
        measured = measure(Clip(frames, times, frames.shape[2:0:-1]), reference, question.own, "after")
        np.testing.assert_allclose(measured.points[option], reference.points[option])
        assert decide(measured, reference.rate).choice == option


@pytest.mark.parametrize(
    ("masks", "why"), [("sam3:x", "there are no masks `sam3:x`"), ("sam2:nowhere", "there is no model in nowhere")]
)
def test_a_model_of_masks_that_is_not_there(masks: str, why: str, films: Path, tmp_path: Path) -> None:
    arguments = ["evaluate", str(films), "-m", "clips:@oracle", "-o", str(tmp_path / "r.parquet"), "--masks", masks]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 2
    assert why in result.output


def test_masks_are_for_clips_alone(films: Path, tmp_path: Path) -> None:
    arguments = ["evaluate", str(films), "-m", "echo:A", "-o", str(tmp_path / "r.parquet"), "--masks", "sam2:x"]
    assert "--masks: only for -m clips:FOLDER" in CliRunner().invoke(main, arguments).output


def test_sam_2_follows_objects(films: Path, tmp_path: Path) -> None:
    """A tiny model with random weights: it finds nothing of sense, but from the same clips the same."""
    frames = np.random.default_rng(0).integers(0, 256, (4, 40, 60, 3), dtype=np.uint8)
    masks = np.zeros((2, 40, 60), bool)
    masks[0, 5:20, 5:20] = True  # the other object is hidden
    folder = tiny_sam_2(tmp_path / "model")
    found = open_tracker(f"sam2:{folder}")(frames, masks)
    assert found.shape == (2, 4, 40, 60)
    assert (found[:, 0] == masks).all()
    assert not found[1].any()

    dataset, rows = DatasetReader.open(films), []
    for name in ("a", "b"):
        run = ClipRun(dataset, "@oracle", Selection(limit=4), masks=f"sam2:{folder}")
        evaluate_clips(run, tmp_path / name / "r.parquet", lambda right, count: None)
        rows.append(pq.read_table(tmp_path / name / "r.parquet").to_pylist())
    assert rows[0] == rows[1]
    assert all(row["status"] in ("answered", "unparsed") for row in rows[0])


def tiny_sam_2(folder: Path) -> Path:
    """Write a small SAM 2 with random weights."""
    torch = pytest.importorskip("torch")
    transformers = pytest.importorskip("transformers")
    side = 128
    backbone = {
        "model_type": "sam2_hiera_det_model", "hidden_size": 16, "image_size": [side, side],
        "embed_dim_per_stage": [16, 32, 64, 128],
    }  # fmt: skip
    vision = {
        "backbone_config": backbone,
        "backbone_channel_list": [128, 64, 32, 16],
        "backbone_feature_sizes": [[side // scale] * 2 for scale in (4, 8, 16)],
    }
    config = transformers.Sam2VideoConfig(
        image_size=side,
        memory_attention_rope_feat_sizes=[side // 16, side // 16],
        memory_attention_num_layers=1,
        vision_config=vision,
        prompt_encoder_config={"image_size": side},
    )
    torch.manual_seed(0)
    transformers.Sam2VideoModel(config).save_pretrained(folder)
    size, mask = ({"height": n, "width": n} for n in (side, side // 4))
    image = transformers.Sam2ImageProcessor(size=size, mask_size=mask)
    transformers.Sam2VideoProcessor(image, transformers.Sam2VideoVideoProcessor(size=size)).save_pretrained(folder)
    return folder
