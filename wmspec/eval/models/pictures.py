"""Several pictures as one: a sheet with labels, or a film."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from wmspec.core.safe_io import picture
from wmspec.dataset.build import typeset, video

_LABEL, _GAP, _MARGIN = 26, 12, 16
#: Pictures a second of a film.
RATE = 2.0


def montage(rows: Sequence[Sequence[tuple[str, bytes]]]) -> bytes:
    """Rows of pictures (PNG), each under its label, on one sheet (PNG) at their own size."""
    out = io.BytesIO()
    drawn = [[(label, opened(png)) for label, png in row] for row in rows if row]
    typeset.grid(drawn, _label, _GAP, _MARGIN).save(out, "PNG", compress_level=1)
    return out.getvalue()


def _label(text: str, width: int) -> Image.Image:
    """In the face that comes with Pillow: the sheet is the same whatever fonts a machine has."""
    paper = typeset.blank(width, round(1.2 * _LABEL))
    ImageDraw.Draw(paper).text((0, 0), text, fill=typeset.BLACK, font=ImageFont.load_default(_LABEL))
    return paper


def clip(pictures: Sequence[bytes]) -> bytes:
    """Pictures (PNG) as an mp4, `RATE` a second. Raises WmsError if `imageio-ffmpeg` is missing."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "clip.mp4"
        video.mp4([opened(png) for png in pictures], RATE, path)
        return path.read_bytes()


def opened(png: bytes) -> Image.Image:
    """A picture of a dataset, in colours."""
    return picture(png, "PNG").convert("RGB")
