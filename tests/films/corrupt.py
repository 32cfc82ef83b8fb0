"""Damage to known futures: kinds that keep what happens, and kinds after which it is none of the futures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.film.codec import Frames, encode_mp4
from wmspec.eval.clips.read import Clip
from wmspec.eval.clips.reference import Reference

Frame = NDArray[np.uint8]


@dataclass(frozen=True)
class Original:
    """A future of a reference, from its last context picture on, as a model would continue it."""

    reference: Reference
    option: int

    @property
    def frames(self) -> Frames:
        film = self.reference.films[self.option]
        return film.frames[film.context - 1 :]

    @property
    def ids(self) -> NDArray[np.int16]:
        film = self.reference.films[self.option]
        return film.ids[film.context - 1 :]

    @property
    def rate(self) -> float:
        return float(self.reference.rate)


def clip(frames: Frames, rate: float) -> Clip:
    frames = np.asarray(frames, np.uint8)
    return Clip(frames, np.arange(len(frames)) / rate, (frames.shape[2], frames.shape[1]))


def each(frames: Frames, change: Callable[[Frame], Frame]) -> Frames:
    return np.stack([change(frame) for frame in frames])


def resampled(frames: Frames, count: int, at: Callable[[int], float]) -> Frames:
    """Frames at fractional places, mixed of the two nearest."""
    made = []
    for i in range(count):
        place = min(max(at(i), 0.0), len(frames) - 1)
        low = int(place)
        part, high = place - low, min(low + 1, len(frames) - 1)
        mixed = (1 - part) * frames[low] + part * frames[high]
        made.append(frames[low] if part < 0.25 else frames[high] if part > 0.75 else mixed.astype(np.uint8))
    return np.stack(made)


def colours(frame: Frame, hue: float, saturation: float, gain: float, gamma: float, offset: float = 0.0) -> Frame:
    hsv = cv2.cvtColor(frame, cv2.COLOR_RGB2HSV).astype(np.float32)
    hsv[..., 0] = (hsv[..., 0] + hue / 2) % 180
    hsv[..., 1] = np.clip(hsv[..., 1] * saturation, 0, 255)
    rgb = cv2.cvtColor(hsv.astype(np.uint8), cv2.COLOR_HSV2RGB).astype(np.float32) / 255
    return np.clip(rgb**gamma * gain * 255 + offset, 0, 255).astype(np.uint8)


def resized(frame: Frame, width: int, height: int) -> Frame:
    return np.asarray(cv2.resize(frame, (width, height), interpolation=cv2.INTER_CUBIC))


def letterbox(frame: Frame) -> Frame:
    height, width = frame.shape[:2]
    canvas = np.zeros((width, width, 3), np.uint8)
    top = (width - height) // 2
    canvas[top : top + height] = frame
    return canvas


def cropped(frame: Frame) -> Frame:
    height, width = frame.shape[:2]
    cut = round(0.1 * width)
    return resized(np.ascontiguousarray(frame[:, cut : width - cut]), 2 * (width - 2 * cut), 2 * height)


def camera(frames: Frames, zoom: float, dx: float, dy: float) -> Frames:
    height, width = frames.shape[1:3]
    made = []
    for i, frame in enumerate(frames):
        u = i / max(1, len(frames) - 1)
        s = 1 + (zoom - 1) * u
        matrix = np.array([[s, 0, (1 - s) * width / 2 + dx * u], [0, s, (1 - s) * height / 2 + dy * u]], np.float32)
        made.append(cv2.warpAffine(frame, matrix, (width, height), borderMode=cv2.BORDER_REFLECT))
    return np.stack(made)


def recomposed(
    original: Original, change: Callable[[float, int], tuple[float, float, float, float, float] | None]
) -> Frames:
    """Every frame again, with each object scaled (x, y), turned in hue and moved (x, y), or left out."""
    plate, made = original.reference.plate, []
    frames, ids = original.frames, original.ids
    height, width = frames.shape[1:3]
    for t, (source, bodies) in enumerate(zip(frames, ids, strict=True)):
        frame, u = source.copy(), t / (len(frames) - 1)
        for body in original.reference.objects:
            mask = bodies == body
            if mask.sum() < 8:
                continue
            around = cv2.dilate(mask.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
            ys, xs = np.nonzero(mask)
            frame[around] = plate[around]
            changed = change(u, t)
            if changed is None:
                continue
            sx, sy, hue, dx, dy = changed
            cx, cy = xs.mean(), ys.mean()
            matrix = np.array([[sx, 0, cx - sx * cx + dx], [0, sy, cy - sy * cy + dy]], np.float32)
            look = colours(source, hue, 1, 1, 1) if hue else source
            moved, where = (
                cv2.warpAffine(pixels, matrix, (width, height), flags=cv2.INTER_NEAREST)
                for pixels in (look, mask.astype(np.uint8))
            )
            frame[where > 0] = moved[where > 0]
        made.append(frame)
    return np.stack(made)


def compressed(frames: Frames, rate: float, quality: int) -> Frames:
    import io

    import av

    even = frames[:, : frames.shape[1] // 2 * 2, : frames.shape[2] // 2 * 2]
    with av.open(io.BytesIO(encode_mp4(even, round(rate), quality))) as container:
        return np.stack([frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)])


def noise(frames: Frames) -> Frames:
    random = np.random.default_rng(1).normal(0, 20, frames.shape)
    return np.clip(frames + random, 0, 255).astype(np.uint8)


def jittered(original: Original) -> Frames:
    # A future at 8 Hz has few frames, and the last counts much: with a larger jitter it ends elsewhere.
    moves = np.random.default_rng(original.option).normal(0, 2, (len(original.frames), 2))
    return recomposed(original, lambda u, t: (1, 1, 0, *moves[t]))


Damage = Callable[[Original], Clip]

#: Damage after which the clip still shows its future.
KEEPS: dict[str, Damage] = {
    "none": lambda o: clip(o.frames, o.rate),
    "h264 at 38": lambda o: clip(compressed(o.frames, o.rate, 38), o.rate),
    "colours": lambda o: clip(each(o.frames, lambda f: colours(f, 8, 1.15, 1.1, 0.9)), o.rate),
    "strong colours": lambda o: clip(each(o.frames, lambda f: colours(f, 20, 0.6, 0.85, 1.3, 25)), o.rate),
    "blur": lambda o: clip(each(o.frames, lambda f: cv2.GaussianBlur(f, (0, 0), 2)), o.rate),
    "noise": lambda o: clip(noise(o.frames), o.rate),
    "letterbox": lambda o: clip(each(o.frames, letterbox), o.rate),
    "crop": lambda o: clip(each(o.frames, cropped), o.rate),
    "square": lambda o: clip(each(o.frames, lambda f: resized(f, 320, 320)), o.rate),
    "half the rate": lambda o: clip(o.frames[::2], o.rate / 2),
    "other rate": lambda o: clip(resampled(o.frames, int(len(o.frames) * 1.25), lambda i: i / 1.25), o.rate * 1.25),
    "slower": lambda o: clip(resampled(o.frames, len(o.frames), lambda i: i / 1.15), o.rate),
    "faster": lambda o: clip(resampled(o.frames, len(o.frames), lambda i: i * 1.15), o.rate),
    "drift": lambda o: clip(camera(o.frames, 1.05, -8, 4), o.rate),
    "shrinks": lambda o: clip(recomposed(o, lambda u, t: (1 - 0.35 * u, 1 - 0.35 * u, 0, 0, 0)), o.rate),
    "deforms": lambda o: clip(recomposed(o, lambda u, t: (1 + 0.4 * u, 1 - 0.25 * u, 0, 0, 0)), o.rate),
    "jitter": lambda o: clip(jittered(o), o.rate),
}


def _mixture(o: Original) -> Clip:
    other = Original(o.reference, (o.option + 1) % len(o.reference.films))
    return clip(((o.frames.astype(np.float32) + other.frames) / 2).astype(np.uint8), o.rate)


def _morph(o: Original) -> Clip:
    last = len(o.frames) - 1
    return clip(np.stack([(1 - i / last) * f + i / last * o.reference.plate for i, f in enumerate(o.frames)]), o.rate)


def _other_scene(o: Original) -> Clip:
    return clip(np.stack([np.roll(255 - f[::-1], 40, axis=1) for f in o.frames]), o.rate)


#: Damage after which the clip shows none of the futures.
SPOILS: dict[str, Damage] = {
    "frozen": lambda o: clip(np.repeat(o.frames[:1], len(o.frames), axis=0), o.rate),
    "mixture": _mixture,
    "vanishes": lambda o: clip(recomposed(o, lambda u, t: None if u > 0.5 else (1, 1, 0, 0, 0)), o.rate),
    "morph": _morph,
    "other scene": _other_scene,
}
