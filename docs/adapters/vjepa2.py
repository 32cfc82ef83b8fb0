"""Surprise of V-JEPA 2: how badly its predictor foresees the latent tokens of the future.

    PYTHONPATH=docs/adapters wmspec evaluate DATASET -m surprise:vjepa2:VJepa2 -o vjepa2.parquet

The variable VJEPA2 names the folder of a model that `transformers` reads, such as vjepa2-vitl-fpc64-256 of Meta.
The surprise is the mean L1 distance of predicted and true tokens of the future, given those of the context.
"""

from __future__ import annotations

import os

import numpy as np
import torch
from numpy.typing import NDArray
from transformers import VJEPA2Model


class VJepa2:
    """A model, loaded once. It sees the last frames of the context, then as many evenly spaced ones of the future."""

    def __init__(self, model: VJEPA2Model | None = None) -> None:
        self.model = (model or VJEPA2Model.from_pretrained(os.environ["VJEPA2"])).eval()
        self.config = self.model.config

    def __call__(self, context: NDArray[np.uint8], future: NDArray[np.uint8], _fps: int, _text: str) -> float:
        """Return the surprise of a future. The model reads neither rate nor text."""
        half = self.config.frames_per_clip // 2
        shown = context[-min(half, len(context)) :]
        shown = np.concatenate([np.repeat(shown[:1], half - len(shown), axis=0), shown])
        later = future[np.linspace(0, len(future) - 1, half).round().astype(int)]
        video = self._pixels(np.concatenate([shown, later]))
        tokens = video.shape[1] // self.config.tubelet_size * (self.config.crop_size // self.config.patch_size) ** 2
        first = torch.arange(tokens // 2)[None]
        second = torch.arange(tokens // 2, tokens)[None]
        with torch.no_grad():
            made = self.model(pixel_values_videos=video, context_mask=[first], target_mask=[second])
        predicted, target = made.predictor_output.last_hidden_state, made.predictor_output.target_hidden_state
        return float((predicted - target).abs().mean())

    def _pixels(self, frames: NDArray[np.uint8]) -> torch.Tensor:
        """Return frames as a batch (1, T, 3, side, side), normalised as in training."""
        video = torch.from_numpy(np.ascontiguousarray(frames)).permute(0, 3, 1, 2).float() / 255
        side = self.config.crop_size
        video = torch.nn.functional.interpolate(video, (side, side), mode="bilinear", antialias=True)
        mean, deviation = torch.tensor([0.485, 0.456, 0.406]), torch.tensor([0.229, 0.224, 0.225])
        return ((video - mean[:, None, None]) / deviation[:, None, None])[None]
