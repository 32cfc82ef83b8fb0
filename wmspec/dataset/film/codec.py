"""Lossless films: H.264 in RGB without quantization, in Matroska; and maps of bodies in the same format.

The bytes depend on the frames and on the version of the encoder, not on the machine: one thread, no dates, no names.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.core.diagnostics import WmsError

Frames = NDArray[np.uint8]
Ids = NDArray[np.signedinteger[Any]]

#: The container of films, whose header says everything: decoding frames to find the format takes longer than opening.
CONTAINER, NO_PROBING = "matroska", {"probesize": "2048", "analyzeduration": "0"}
#: Lossless. Without arithmetic coding and large transforms, films are decoded in less than half the time.
LOSSLESS = {"qp": "0", "preset": "fast", "x264-params": "cabac=0:8x8dct=0"}


def pyav() -> Any:
    """Return the module `av`. Raises WmsError if it is not installed."""
    try:
        import av
    except ImportError:
        raise WmsError("films need PyAV", help="install it with `pip install 'wmspec[clips]'`") from None
    return av


def encode(frames: Frames, rate: int) -> bytes:
    """Return frames (T, h, w, 3), sRGB, as a lossless film with `rate` frames per second."""
    return _encoded(frames, rate, "libx264rgb", CONTAINER, LOSSLESS, "rgb24")


def encode_mp4(frames: Frames, rate: int, quality: int = 8) -> bytes:
    """Return frames (T, h, w, 3) as an MP4 that every player reads (H.264, 4:2:0), with a constant rate factor."""
    return _encoded(frames, rate, "libx264", "mp4", {"crf": str(quality), "preset": "medium"}, "yuv420p")


def decode(content: bytes) -> Frames:
    """Return the frames (T, h, w, 3) of a film that wmspec wrote. Raises WmsError if the content is damaged."""
    av = pyav()
    try:
        with av.open(io.BytesIO(content), format=CONTAINER, options=NO_PROBING) as container:
            stream = container.streams.video[0]
            stream.thread_count = 1
            frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
    except (av.FFmpegError, IndexError, ValueError) as error:
        raise WmsError(f"a film that cannot be decoded ({error})") from None
    if not frames:
        raise WmsError("a film without frames")
    return np.stack(frames)


def encode_ids(ids: Ids, rate: int) -> bytes:
    """Return the body of each pixel (T, h, w), -1 for none, as a lossless film: low byte red, high byte green."""
    shifted = (ids + 1).astype(np.uint16)
    planes = ((shifted & 255), (shifted >> 8), np.zeros_like(shifted))
    return encode(np.stack(planes, axis=-1).astype(np.uint8), rate)


def scaler(size: tuple[int, int] | None) -> Callable[[Any], Frames]:
    """Return a function of PyAV's frames that returns them as pictures (h, w, 3), sRGB, scaled to `size` (px).

    It is to be used for frames of one size and format: the tables of the scaler are computed once.
    """
    from av.video.reformatter import VideoReformatter

    shrink, interleave = VideoReformatter(), VideoReformatter()

    def scaled(frame: Any) -> Frames:
        if size is not None:
            # One step from the film's format to small interleaved pictures takes twice the time.
            planes = shrink.reformat(frame, *size, format="gbrp", interpolation="AREA")
            frame = interleave.reformat(planes, format="rgb24")
        made: Frames = frame.to_ndarray(format="rgb24")
        return made

    return scaled


def _encoded(frames: Frames, rate: int, codec: str, container: str, options: dict[str, str], pixels: str) -> bytes:
    av = pyav()
    sink = io.BytesIO()
    with av.open(sink, "w", format=container, options={"fflags": "+bitexact"}) as file:
        stream: Any = file.add_stream(codec, rate=Fraction(rate))
        stream.height, stream.width = frames.shape[1:3]
        stream.pix_fmt = pixels
        stream.options = options
        stream.codec_context.thread_count = 1
        if pixels == "yuv420p":
            _tag_bt709(stream.codec_context)
        for frame in frames:
            picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")
            if pixels == "yuv420p":
                picture = picture.reformat(format=pixels, dst_colorspace="ITU709")
            file.mux(stream.encode(picture))
        file.mux(stream.encode())
    return sink.getvalue()


def _tag_bt709(context: Any) -> None:
    """Record the colour space, primaries, transfer and range of an MP4, so that players agree on colours."""
    context.colorspace = context.color_primaries = context.color_trc = 1
    context.color_range = 1
