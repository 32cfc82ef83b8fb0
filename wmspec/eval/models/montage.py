"""Several pictures as one: a labelled sheet, or a video."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from wmspec.core.safe_io import load_image
from wmspec.dataset.build import typeset, video

_LABEL, _GAP, _MARGIN = 26, 12, 16
#: Frame rate of a video (Hz).
VIDEO_RATE = 2.0


def montage(rows: Sequence[Sequence[tuple[str, bytes]]]) -> bytes:
    """Return rows of labelled pictures (PNG) as one sheet (PNG) at original size."""
    out = io.BytesIO()
    drawn = [[(label, decode_image(png)) for label, png in row] for row in rows if row]
    typeset.grid(drawn, _label, _GAP, _MARGIN).save(out, "PNG", compress_level=1)
    return out.getvalue()


def _label(text: str, width: int) -> Image.Image:
    """Return a label in Pillow's built-in font, so that the sheet does not depend on installed fonts."""
    paper = typeset.blank(width, round(1.2 * _LABEL))
    ImageDraw.Draw(paper).text((0, 0), text, fill=typeset.BLACK, font=ImageFont.load_default(_LABEL))
    return paper


def encode_video(pictures: Sequence[bytes]) -> bytes:
    """Return pictures (PNG) as an mp4 at `VIDEO_RATE` Hz. Raises WmsError if `imageio-ffmpeg` is missing."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "clip.mp4"
        video.mp4([decode_image(png) for png in pictures], VIDEO_RATE, path)
        return path.read_bytes()


def decode_image(png: bytes) -> Image.Image:
    """Decode a picture (RGB)."""
    return load_image(png, "PNG").convert("RGB")
