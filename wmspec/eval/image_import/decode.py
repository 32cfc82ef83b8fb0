"""Photographs and clips: validated, turned upright, converted to sRGB, resized, and encoded without metadata."""

from __future__ import annotations

import hashlib
import io
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageCms, ImageOps

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.limits import PIXELS
from wmspec.core.safe_io import is_within, regular_file

#: File suffixes of pictures and clips. Animated pictures (GIF, WebP, PNG) count as clips too.
STILL_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp", ".gif")
CLIP_SUFFIXES = (".mp4", ".mov", ".webm", ".mkv", ".avi")
#: Permitted formats of Pillow and FFmpeg; others are refused.
_STILL_FORMATS = ("PNG", "JPEG", "WEBP", "TIFF", "BMP", "GIF")
_CLIP_FORMATS = ["-protocol_whitelist", "file", "-format_whitelist", "mov,matroska,webm,avi"]
#: Minimum side of a picture (px).
MIN_SIDE = 16

Pixels = NDArray[np.uint8]


class PictureFolder:
    """The pictures of a folder, scaled down to sides of at most `size` (px)."""

    def __init__(self, folder: Path, size: int) -> None:
        self._folder, self._size = folder, size
        self._names = {str(p.relative_to(folder)): p for p in sorted(folder.rglob("*")) if p.is_file()}
        self.used: set[str] = set()

    @property
    def unused(self) -> tuple[str, ...]:
        """The names of pictures and clips that were never requested."""
        return tuple(
            n
            for n, p in self._names.items()
            if n not in self.used and p.suffix.lower() in (*STILL_SUFFIXES, *CLIP_SUFFIXES)
        )

    def moves(self, name: str) -> bool:
        """Whether a file is a picture with several frames."""
        path = self._names.get(name)
        if path is None or path.suffix.lower() not in STILL_SUFFIXES or not is_within(self._folder, path):
            return False
        try:
            with _with_remedies(name), _open_image(path) as picture:
                return bool(getattr(picture, "n_frames", 1) > 1 and picture.format != "TIFF")
        except WmsError:
            return False

    def digest(self, name: str) -> bytes:
        """Return a hash that is equal for two photographs exactly if their pixels are."""
        pixels = self.still(name)
        return hashlib.sha256(repr(pixels.shape).encode() + pixels.tobytes()).digest()

    def still(self, name: str) -> Pixels:
        """Return a photograph (h, w, 3). Raises WmsError if it is missing or unreadable."""
        path = self._path(name, STILL_SUFFIXES)
        with _with_remedies(name), _open_image(path) as picture:
            pixels = self._ready(picture, name)
        return pixels

    def frames(self, name: str, count: int) -> tuple[list[Pixels], list[float]]:
        """Return `count` evenly spaced frames of a clip (h, w, 3), including first and last, and their times (s).

        Raises WmsError if the clip is missing or unreadable, has fewer frames, or if the decoder is not installed.
        """
        path = self._path(name, (*STILL_SUFFIXES, *CLIP_SUFFIXES))
        if path.suffix.lower() in STILL_SUFFIXES:
            return self._animated(path, name, count)
        return self._film(path, name, count)

    # ------------------------------------------------------------ files

    def _path(self, name: str, endings: Sequence[str]) -> Path:
        if name not in self._names:
            place = PurePosixPath(name)
            if place.is_absolute() or ".." in place.parts:
                raise WmsError(
                    f"`{name}` leads out of the folder", help=f"put it into {self._folder}, and write its name there"
                )
            remedy = suggestion(name, self._names)
            raise WmsError(
                f"there is no `{name}` in {self._folder}", help=remedy or "put it there, or correct the name"
            )
        path = self._names[name]
        if not is_within(self._folder, path):
            raise WmsError(f"`{name}` is a link that leads out of the folder", help="put the file itself there")
        if path.suffix.lower() not in endings:
            raise WmsError(f"`{name}` has an unsupported format", help=f"save it as one of {', '.join(endings)}")
        self.used.add(name)
        return path

    def _ready(self, picture: Image.Image, name: str) -> Pixels:
        """Return the pixels of a picture (h, w, 3): upright, in sRGB, on white, at most the maximum size."""
        if min(picture.size) < MIN_SIDE:
            wide, high = picture.size
            raise WmsError(
                f"`{name}` has {wide} × {high} pixels", help=f"give a picture of at least {MIN_SIDE} × {MIN_SIDE}"
            )
        picture.draft("RGB", (2 * self._size, 2 * self._size))  # decodes JPEGs at reduced size, which is faster
        profile = picture.info.get("icc_profile")
        upright = ImageOps.exif_transpose(picture)
        colored = _flatten(upright)
        if profile and upright.mode in ("RGB", "RGBA"):
            colored = _to_srgb(colored, profile)
        colored.thumbnail((self._size, self._size), Image.Resampling.LANCZOS)
        return np.asarray(colored, np.uint8)

    def _animated(self, path: Path, name: str, count: int) -> tuple[list[Pixels], list[float]]:
        with _with_remedies(name), _open_image(path) as picture:
            total = int(getattr(picture, "n_frames", 1))
            selected = set(_even_indices(name, total, count))
            pixels, times, now = [], [], 0.0
            for number in range(total):
                picture.seek(number)
                if number in selected:
                    pixels.append(self._ready(picture.copy(), name))
                    times.append(now)
                now += picture.info.get("duration", 100) / 1000
        return pixels, [round(t, 3) for t in times]

    def _film(self, path: Path, name: str, count: int) -> tuple[list[Pixels], list[float]]:
        try:
            import imageio_ffmpeg
        except ImportError:
            raise WmsError(
                f"`{name}` needs imageio-ffmpeg", help="install it with `pip install 'wmspec[video]'`, or give a .gif"
            ) from None
        try:
            reader = imageio_ffmpeg.read_frames(str(path), input_params=_CLIP_FORMATS)
            about = next(reader)
            (wide, high), rate = about["size"], about["fps"]
            if wide * high > PIXELS.most:
                raise _too_large(name)
            total, _ = imageio_ffmpeg.count_frames_and_secs(str(path))
            selected = set(_even_indices(name, total, count))
            frames = (
                (n, Image.frombytes("RGB", (wide, high), frame)) for n, frame in enumerate(reader) if n in selected
            )
            shown = [
                (n, self._ready(picture, name)) for n, picture in frames
            ]  # scale each frame before decoding the next
            return [pixels for _, pixels in shown], [round(n / rate, 3) for n, _ in shown]
        except (OSError, RuntimeError, ValueError, LookupError, ArithmeticError, StopIteration):
            raise WmsError(f"`{name}` cannot be read", help="save the clip again, as .mp4") from None


def _even_indices(name: str, total: int, count: int) -> Iterator[int]:
    if total < count:
        raise WmsError(f"`{name}` has {total} pictures, {count} are wanted", help=f"write at most {total} in `frames`")
    yield from (round(i) for i in np.linspace(0, total - 1, count))


def _open_image(path: Path) -> Image.Image:
    """Open a picture without decoding it. Raises OSError and others, see `_with_remedies`."""
    picture = Image.open(regular_file(path), "r", _STILL_FORMATS)
    if picture.width * picture.height > PIXELS.most:
        raise Image.DecompressionBombError
    return picture


def _too_large(name: str) -> WmsError:
    return WmsError(f"`{name}` {PIXELS.sentence}", help=PIXELS.help)


@contextmanager
def _with_remedies(name: str) -> Iterator[None]:
    """Turn errors of decoding into a WmsError."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # Pillow raises an error at twice the limit
            yield
    except Image.DecompressionBombError:
        raise _too_large(name) from None
    except (OSError, SyntaxError, ValueError, EOFError, MemoryError, AttributeError, IndexError, KeyError, TypeError):
        raise WmsError(f"`{name}` cannot be read: it is damaged, or no picture", help="save it again") from None


def _flatten(picture: Image.Image) -> Image.Image:
    """Return a picture in RGB, on white where transparent; 16-bit greys become 8-bit ones."""
    if picture.mode.startswith("I"):
        grey = np.asarray(picture, np.float64)
        picture = Image.fromarray((grey / (257 if grey.max() > 255 else 1)).astype(np.uint8))
    if "A" in picture.getbands() or "transparency" in picture.info:
        layer = picture.convert("RGBA")
        picture = Image.alpha_composite(Image.new("RGBA", layer.size, "white"), layer)
    return picture.convert("RGB")


def _to_srgb(picture: Image.Image, profile: bytes) -> Image.Image:
    """Return a picture in sRGB; an unreadable profile is ignored."""
    try:
        source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        return ImageCms.profileToProfile(picture, source, ImageCms.createProfile("sRGB"), outputMode="RGB") or picture
    except (ImageCms.PyCMSError, OSError):
        return picture
