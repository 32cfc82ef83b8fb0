"""Photographs and clips: checked, turned upright, brought to sRGB and to a size, and encoded without metadata."""

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
from wmspec.core.safe_io import inside

#: The endings of files that are read: pictures, and clips. A picture that moves (GIF, WebP, PNG) is a clip too.
STILLS = (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp", ".gif")
CLIPS = (".mp4", ".mov", ".webm", ".mkv", ".avi")
#: What these are to Pillow, and to FFmpeg: a file is read as nothing else, whatever it looks like inside.
_STILL_FORMATS = ("PNG", "JPEG", "WEBP", "TIFF", "BMP", "GIF")
_CLIP_FORMATS = ["-protocol_whitelist", "file", "-format_whitelist", "mov,matroska,webm,avi"]
#: The least side of a picture (px).
LEAST = 16

Pixels = NDArray[np.uint8]


class Pictures:
    """The pictures of a folder, none with a side longer than `size` (px)."""

    def __init__(self, folder: Path, size: int) -> None:
        self._folder, self._size = folder, size
        self._names = {str(p.relative_to(folder)): p for p in sorted(folder.rglob("*")) if p.is_file()}
        self.used: set[str] = set()

    @property
    def unused(self) -> tuple[str, ...]:
        """The names of pictures and clips in the folder that nothing has asked for."""
        return tuple(n for n, p in self._names.items() if n not in self.used and p.suffix.lower() in (*STILLS, *CLIPS))

    def moves(self, name: str) -> bool:
        """Whether a file is a picture with several frames."""
        path = self._names.get(name)
        if path is None or path.suffix.lower() not in STILLS or not inside(self._folder, path):
            return False
        try:
            with _explained(name), _opened(path) as picture:
                return bool(getattr(picture, "n_frames", 1) > 1 and picture.format != "TIFF")
        except WmsError:
            return False

    def digest(self, name: str) -> bytes:
        """What two photographs have in common exactly if they look the same to the pixel."""
        pixels = self.still(name)
        return hashlib.sha256(repr(pixels.shape).encode() + pixels.tobytes()).digest()

    def still(self, name: str) -> Pixels:
        """A photograph (h, w, 3). Raises WmsError if it is not there or cannot be shown."""
        path = self._path(name, STILLS)
        with _explained(name), _opened(path) as picture:
            pixels = self._ready(picture, name)
        return pixels

    def frames(self, name: str, count: int) -> tuple[list[Pixels], list[float]]:
        """So many pictures of a clip (h, w, 3), from the first to the last evenly, and their times (s).

        Raises WmsError if it is not there or cannot be shown, if it has fewer, or if what reads it is not installed.
        """
        path = self._path(name, (*STILLS, *CLIPS))
        if path.suffix.lower() in STILLS:
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
        if not inside(self._folder, path):
            raise WmsError(f"`{name}` is a link that leads out of the folder", help="put the file itself there")
        if path.suffix.lower() not in endings:
            raise WmsError(
                f"`{name}` is no kind of picture that can be read", help=f"save it as one of {', '.join(endings)}"
            )
        self.used.add(name)
        return path

    def _ready(self, picture: Image.Image, name: str) -> Pixels:
        """A picture as its pixels (h, w, 3): upright, in sRGB, on white, no larger than wanted."""
        if min(picture.size) < LEAST:
            wide, high = picture.size
            raise WmsError(f"`{name}` has {wide} × {high} pixels", help=f"give a picture of at least {LEAST} × {LEAST}")
        picture.draft("RGB", (2 * self._size, 2 * self._size))  # JPEGs are read smaller, which is quicker
        profile = picture.info.get("icc_profile")
        upright = ImageOps.exif_transpose(picture)
        colored = _opaque(upright)
        if profile and upright.mode in ("RGB", "RGBA"):
            colored = _in_srgb(colored, profile)
        colored.thumbnail((self._size, self._size), Image.Resampling.LANCZOS)
        return np.asarray(colored, np.uint8)

    def _animated(self, path: Path, name: str, count: int) -> tuple[list[Pixels], list[float]]:
        with _explained(name), _opened(path) as picture:
            total = int(getattr(picture, "n_frames", 1))
            wanted = set(_evenly(name, total, count))
            pixels, times, now = [], [], 0.0
            for number in range(total):
                picture.seek(number)
                if number in wanted:
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
            wanted = set(_evenly(name, total, count))
            frames = ((n, Image.frombytes("RGB", (wide, high), frame)) for n, frame in enumerate(reader) if n in wanted)
            shown = [(n, self._ready(picture, name)) for n, picture in frames]  # small, before the next one comes
            return [pixels for _, pixels in shown], [round(n / rate, 3) for n, _ in shown]
        except (OSError, RuntimeError, ValueError, LookupError, ArithmeticError, StopIteration):
            raise WmsError(f"`{name}` cannot be read", help="save the clip again, as .mp4") from None


def _evenly(name: str, total: int, count: int) -> Iterator[int]:
    if total < count:
        raise WmsError(f"`{name}` has {total} pictures, {count} are wanted", help=f"write at most {total} in `frames`")
    yield from (round(i) for i in np.linspace(0, total - 1, count))


def _opened(path: Path) -> Image.Image:
    """A picture, not read yet. Raises OSError and others, which `_explained` explains."""
    picture = Image.open(path, "r", _STILL_FORMATS)
    if picture.width * picture.height > PIXELS.most:
        raise Image.DecompressionBombError
    return picture


def _too_large(name: str) -> WmsError:
    return WmsError(f"`{name}` {PIXELS.sentence}", help=PIXELS.help)


@contextmanager
def _explained(name: str) -> Iterator[None]:
    """Turn what goes wrong when a picture is read into a WmsError."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # twice as many pixels are an error
            yield
    except Image.DecompressionBombError:
        raise _too_large(name) from None
    except (OSError, SyntaxError, ValueError, EOFError, MemoryError, AttributeError, IndexError, KeyError, TypeError):
        raise WmsError(f"`{name}` cannot be read: it is damaged, or no picture", help="save it again") from None


def _opaque(picture: Image.Image) -> Image.Image:
    """In RGB, what is transparent on white; 16-bit greys become 8-bit ones."""
    if picture.mode.startswith("I"):
        grey = np.asarray(picture, np.float64)
        picture = Image.fromarray((grey / (257 if grey.max() > 255 else 1)).astype(np.uint8))
    if "A" in picture.getbands() or "transparency" in picture.info:
        layer = picture.convert("RGBA")
        picture = Image.alpha_composite(Image.new("RGBA", layer.size, "white"), layer)
    return picture.convert("RGB")


def _in_srgb(picture: Image.Image, profile: bytes) -> Image.Image:
    """In sRGB. A profile that cannot be read is as good as none."""
    try:
        source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        return ImageCms.profileToProfile(picture, source, ImageCms.createProfile("sRGB"), outputMode="RGB") or picture
    except (ImageCms.PyCMSError, OSError):
        return picture
