"""Animated GIFs, and MP4s if `imageio-ffmpeg` is installed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace

Picture = Image.Image

PALETTE_SIZE = 255
"""Palette size of a GIF frame."""


def gif(pictures: Iterable[Picture], rate: float, path: Path) -> None:
    """Write an endlessly repeating GIF. Frame times are whole hundredths of a second, so the rate (Hz) holds on
    average.
    """
    shown = [picture.quantize(PALETTE_SIZE, dither=Image.Dither.NONE) for picture in pictures]
    ends = [round(100 * (i + 1) / rate) for i in range(len(shown))]
    lasting = [10 * (end - begin) for begin, end in zip([0, *ends], ends, strict=False)]
    shown[0].save(path, format="GIF", save_all=True, append_images=shown[1:], duration=lasting, loop=0)


def mp4(pictures: Iterable[Picture], rate: float, path: Path) -> None:
    """Write an MP4 (H.264). Raises WmsError if `imageio-ffmpeg` is missing."""
    try:
        import imageio_ffmpeg
    except ImportError:
        raise WmsError(
            "MP4 needs imageio-ffmpeg",
            FilePlace(str(path)),
            "install it with `pip install 'wmspec[video]'`, or write a .gif",
        ) from None
    shown = [np.asarray(picture.convert("RGB")) for picture in pictures]
    height, width, _ = shown[0].shape
    even = (width - width % 2, height - height % 2)  # H.264 subsamples chroma by 2
    same_bytes = ["-fflags", "+bitexact", "-flags:v", "+bitexact"]
    colors = ["-vf", "scale=out_color_matrix=bt709:out_range=tv", "-color_range", "tv"]
    colors += [word for what in ("space", "_primaries", "_trc") for word in (f"-color{what}", "bt709")]
    writer: Any = imageio_ffmpeg.write_frames(
        str(path), even, fps=rate, codec="libx264", quality=8, macro_block_size=2, output_params=colors + same_bytes
    )
    writer.send(None)
    for picture in shown:
        writer.send(np.ascontiguousarray(picture[: even[1], : even[0]]))
    writer.close()


WRITERS: dict[str, Callable[[Iterable[Picture], float, Path], None]] = {".gif": gif, ".mp4": mp4}
"""Writer by file suffix."""
