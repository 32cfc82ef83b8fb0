"""The format, size and detail in which pictures are sent; several as a labelled sheet or a video."""

from __future__ import annotations

import io
import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from PIL import Image, ImageDraw, ImageFont

from wmspec.core.diagnostics import WmsError
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


Detail = Literal["low", "high", "auto", "original"]
_FORMAT = re.compile(r"(png|jpeg|webp)(?::(\d{1,3}))?")
#: Default quality of lossy formats.
DEFAULT_QUALITY = 90


@dataclass(frozen=True)
class ImageOptions:
    """How pictures are sent: format, quality if lossy, longest side (px, None: as it is), and OpenAI's detail."""

    format: Literal["png", "jpeg", "webp"] = "png"
    quality: int = DEFAULT_QUALITY
    size: int | None = None
    detail: Detail | None = None

    @classmethod
    def parse(cls, text: str, size: int | None, detail: Detail | None) -> ImageOptions:
        """Return options from a format such as `jpeg:90`. Raises WmsError for an unknown one."""
        match = _FORMAT.fullmatch(text.strip().lower().replace("jpg", "jpeg"))
        quality = int(match[2] or DEFAULT_QUALITY) if match else 0
        if match is None or not 1 <= quality <= 100 or (match[1] == "png" and match[2]):
            raise WmsError(f"--image-format {text}: expected png, or jpeg or webp with a quality such as jpeg:90")
        return cls(match[1], quality, size, detail)  # type: ignore[arg-type]

    @property
    def record(self) -> str | None:
        """The options as text, for the settings of a run; None for the defaults."""
        if self == ImageOptions():
            return None
        quality = "" if self.format == "png" else f":{self.quality}"
        return " ".join(filter(None, (self.format + quality, f"{self.size} px" if self.size else None, self.detail)))

    def encode(self, png: bytes) -> tuple[str, bytes]:
        """Return the MIME type and content of a picture (PNG). An unchanged PNG stays the same to the byte."""
        if self.format == "png" and self.size is None:
            return "image/png", png
        image, content = self.scale(decode_image(png)), io.BytesIO()
        if self.format == "png":
            image.save(content, "PNG")
        else:
            image.save(content, self.format.upper(), quality=self.quality)
        return f"image/{self.format}", content.getvalue()

    def scale(self, image: Image.Image) -> Image.Image:
        """Return an image with the longest side of these options."""
        if self.size is None or max(image.size) == self.size:
            return image
        factor = self.size / max(image.size)
        size = (max(1, round(image.width * factor)), max(1, round(image.height * factor)))
        return image.resize(size, Image.Resampling.LANCZOS)


#: Pictures as they are in the dataset.
AS_THEY_ARE = ImageOptions()
