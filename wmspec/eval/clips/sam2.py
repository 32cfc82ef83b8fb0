"""Masks of objects by SAM 2 (Ravi et al., 2024), which follows them from the last frame of the context on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.dataset.film.codec import Frames
from wmspec.dataset.film.distances import Mask

#: Returns the masks (objects, n, h, w) of objects in frames (n, h, w, 3), given those (objects, h, w) of the first.
Tracker = Callable[[Frames, Mask], Mask]
#: How `--masks` names the model.
PREFIX = "sam2:"


def open_tracker(name: str) -> Tracker:
    """Return the tracker `sam2:FOLDER`, a model that `transformers` reads. Raises WmsError if it cannot be loaded."""
    folder = Path(name.removeprefix(PREFIX))
    if not name.startswith(PREFIX):
        raise WmsError(f"--masks: there are no masks `{name}`", help=f"write `--masks {PREFIX}FOLDER`")
    if not (folder / "config.json").is_file():
        raise WmsError(
            f"--masks: there is no model in {folder}", help="download one, such as facebook/sam2.1-hiera-tiny"
        )
    try:
        import torch
        from transformers import Sam2VideoModel, Sam2VideoProcessor
    except ImportError:
        raise WmsError(
            "SAM 2 needs transformers and torch", help="install them: `pip install 'wmspec[local]'`"
        ) from None
    try:
        model = Sam2VideoModel.from_pretrained(folder, local_files_only=True).eval()
        processor = Sam2VideoProcessor.from_pretrained(folder, local_files_only=True)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise WmsError(f"--masks: {folder} cannot be loaded as SAM 2: {str(error).splitlines()[0]}") from None

    def follow(frames: Frames, masks: Mask) -> Mask:
        made = np.zeros((len(masks), len(frames), *masks.shape[1:]), bool)
        seen = [k for k, mask in enumerate(masks) if mask.any()]
        if not seen:
            return made
        with torch.inference_mode():
            session = processor.init_video_session(video=list(frames), dtype=torch.float32)
            given = {"obj_ids": seen, "input_masks": [masks[k] for k in seen]}
            processor.add_inputs_to_inference_session(inference_session=session, frame_idx=0, **given)
            model(inference_session=session, frame_idx=0)
            for output in model.propagate_in_video_iterator(session):
                (found,) = processor.post_process_masks([output.pred_masks], original_sizes=[masks.shape[1:]])
                made[seen, output.frame_idx] = found[:, 0].numpy()
        made[:, 0] = masks
        return made

    return follow
