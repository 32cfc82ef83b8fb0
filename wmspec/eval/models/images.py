"""The format, size and detail in which pictures are sent."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from typing import Literal

from PIL import Image

from wmspec.core.diagnostics import WmsError
from wmspec.eval.models.montage import decode_image

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
