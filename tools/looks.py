"""Generate the textures of materials in `wmspec/looks/textures`: grey, to be tinted by the colour of an object.

python tools/looks.py            writes them
python tools/looks.py --check    exits with 1 if one is not current

All textures tile without seams: noise consists of waves with a whole number of periods per image.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from wmspec.sim.materials import TEXTURE_SIZE, TEXTURES

Grey = NDArray[np.float64]
"""(SIZE, SIZE) sRGB values 0..1, or any field of this shape."""

Y, X = np.mgrid[0:TEXTURE_SIZE, 0:TEXTURE_SIZE] / TEXTURE_SIZE
TOLERANCE = 1
"""Accepted difference of a texel (of 255), since mathematics libraries round differently."""


def noise(seed: int, slope: float, across: float = 1.0, along: float = 1.0, least: float = 1.0) -> Grey:
    """Random waves, of mean 0 and deviation 1, whose amplitude falls with their frequency to the power of `slope`.

    Frequencies count `across` times in x and `along` times in y (so `across` > 1 draws the noise out in y); those below
    `least` waves an image are left out.
    """
    draws = np.random.default_rng(seed).standard_normal((TEXTURE_SIZE, TEXTURE_SIZE))
    wave = np.fft.fftfreq(TEXTURE_SIZE, 1 / TEXTURE_SIZE)
    frequency = np.hypot(across * wave[None, :], along * wave[:, None])
    weight = np.where(frequency >= least, np.maximum(frequency, 1e-9) ** -slope, 0)
    field: Grey = np.fft.ifft2(np.fft.fft2(draws) * weight).real
    return (field - field.mean()) / field.std()


def level(field: Grey, dark: float, light: float) -> Grey:
    """Map the 1st to 99th percentile of a field to the range between two greys."""
    low, high = np.percentile(field, (1, 99))
    return dark + (light - dark) * np.clip((field - low) / (high - low), 0, 1)


def soft(edge: Grey, width: float) -> Grey:
    """Return a smooth step over `width`: 0 for `edge` < 0, 1 for `edge` > 0."""
    t = np.clip(edge / width + 0.5, 0, 1)
    return t * t * (3 - 2 * t)


def wood() -> Grey:
    """Year rings cut lengthwise: wavy bands along x with a sharp dark end, and fine fibres."""
    phase = 6 * Y + 0.30 * noise(1, 2.6, across=4) + 0.05 * noise(2, 1.5, across=8)
    ring = phase % 1
    band = ring**2 * soft(0.95 - ring, 0.10)
    fibre = noise(3, 0.9, across=10, least=14)
    return np.clip(0.97 - 0.38 * band - 0.04 * fibre, 0, 1)


def marble() -> Grey:
    """Veins where warped waves cross zero, in two strengths, on a cloudy ground."""
    warp = noise(11, 2.0)
    coarse = np.abs(np.sin(np.pi * (X + 2 * Y + 0.45 * warp)))
    fine = np.abs(np.sin(np.pi * (3 * X - 2 * Y + 0.6 * noise(12, 1.8))))
    strength = soft(noise(13, 2.5), 2.0)
    veins = 0.80 * np.exp(-coarse / 0.20) + 0.45 * strength * np.exp(-fine / 0.16)
    return np.clip(0.98 - veins - 0.035 * noise(14, 1.6), 0, 1)


def stone() -> Grey:
    """Grains of three kinds of rock, dark, grey and white, each of one tone."""
    dice = np.random.default_rng(21)
    place, tone = dice.random((700, 2)), dice.choice([0.30, 0.62, 0.80, 1.0], 700, p=[0.24, 0.3, 0.26, 0.2])
    apart = np.abs(np.stack([X, Y], 2)[:, :, None] - place)
    nearest = (np.minimum(apart, 1 - apart) ** 2).sum(3).argmin(2)
    return np.clip(tone[nearest] - 0.03 * noise(22, 0.5), 0, 1)


def metal() -> Grey:
    """Strokes along x, and broad bands as if lamps and walls were reflected."""
    stroke = noise(31, 0.35, across=40, least=6)
    band = 0.5 + 0.36 * np.sin(2 * np.pi * (Y + 0.1)) + 0.14 * np.sin(2 * np.pi * (2 * Y + 0.45))
    return np.clip(0.40 + 0.60 * band - 0.10 * stroke, 0, 1)


def fabric() -> Grey:
    """A plain weave: threads go over and under one another, each round, with dark gaps."""
    threads = 8
    u, v = threads * X, threads * Y
    over = (np.floor(u) + np.floor(v)) % 2 == 0
    a, b = np.where(over, u % 1, v % 1) - 0.5, np.where(over, v % 1, u % 1) - 0.5
    height = np.sqrt(np.clip(1 - (2.05 * a) ** 2, 0, 1)) * (1 - 1.1 * b**2)
    return np.clip(0.38 + 0.58 * height - 0.035 * noise(41, 0.4), 0, 1)


def rubber() -> Grey:
    """Rows of round studs, lit from above."""
    rows = 4
    u, v = rows * X, rows * Y
    a, b = u % 1 - 0.5, v % 1 - 0.5
    away = np.hypot(a, b)
    stud = soft(0.34 - away, 0.10)
    rim = np.exp(-(((away - 0.34) / 0.07) ** 2)) * -b / 0.34
    return np.clip(0.62 + 0.2 * stud + 0.30 * rim, 0, 1)


def glass() -> Grey:
    """Streaks of light at a slant, broad and narrow, on an even ground."""
    slant = X + Y + 0.02 * noise(51, 3.0)
    broad = soft(np.cos(2 * np.pi * slant) - 0.72, 0.14)
    narrow = soft(np.cos(2 * np.pi * (slant - 0.27)) - 0.965, 0.03)
    return 0.66 + 0.34 * np.clip(broad + narrow, 0, 1) - 0.06 * np.cos(2 * np.pi * Y)


def checker() -> Grey:
    """Two by two squares."""
    return np.where((np.floor(2 * X) + np.floor(2 * Y)) % 2 == 0, 1.0, 0.34)


def stripes() -> Grey:
    """A light and a dark stripe, each as wide as a square of the checker."""
    return np.where(np.floor(2 * Y) % 2 == 0, 1.0, 0.34)


def brick() -> Grey:
    """Bricks in rows, each of its own tone, half a brick aside from row to row, with light mortar."""
    rows, long = 4, 2
    v = rows * Y
    row = np.floor(v).astype(int)
    u = (long * X + 0.5 * (row % 2)) % long
    tone = np.random.default_rng(61).uniform(0.58, 0.82, (rows, long))[row, np.floor(u).astype(int)]
    edge = np.minimum(np.minimum(u % 1, 1 - u % 1) * 2, np.minimum(v % 1, 1 - v % 1))
    face = soft(edge - 0.07, 0.05)
    return np.clip(face * (tone + 0.05 * noise(62, 0.7)) + (1 - face) * (0.97 + 0.02 * noise(63, 0.4)), 0, 1)


def tiles() -> Grey:
    """Two by two glazed tiles with dark joints."""
    u, v = 2 * X % 1, 2 * Y % 1
    edge = np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v))
    return np.clip(0.62 + 0.36 * soft(edge - 0.025, 0.02) - 0.015 * noise(71, 2.0), 0, 1)


def planks() -> Grey:
    """Boards along x, each with its own tone and grain, butted at different places, with dark gaps."""
    boards = 4
    v = boards * Y
    board = np.floor(v).astype(int)
    ends = np.array([0.1, 0.6, 0.35, 0.85])[board]
    tone = np.random.default_rng(81).uniform(0.72, 0.95, boards)[board]
    end = np.abs((X - ends + 0.5) % 1 - 0.5)
    gap = soft(0.012 - np.minimum(np.minimum(v % 1, 1 - v % 1) / boards * 2, end), 0.008)
    grain = 0.06 * noise(82, 1.3, across=9, least=3) + 0.03 * noise(83, 0.9, across=14, least=14)
    return np.clip((tone - grain) * (1 - 0.6 * gap), 0, 1)


def carpet() -> Grey:
    """Tufts of wool: light heads with dark between them."""
    return level(noise(91, 0.4, least=12) + 0.4 * noise(92, 0.9, least=10), 0.55, 1.0)


def leather() -> Grey:
    """Pebbles with dark creases between them."""
    place = np.random.default_rng(101).random((420, 2))
    apart = np.abs(np.stack([X, Y], 2)[:, :, None] - place)
    near = np.sort((np.minimum(apart, 1 - apart) ** 2).sum(3), axis=2)[:, :, :2]
    crease = np.sqrt(near[:, :, 1]) - np.sqrt(near[:, :, 0])
    return np.clip(0.62 + 0.36 * soft(crease - 0.006, 0.012) - 0.02 * noise(102, 1.0), 0, 1)


def paper() -> Grey:
    """Edges of pages, or the fibres of card: fine lines along x."""
    return np.clip(0.93 + 0.045 * noise(111, 0.3, across=60, least=20), 0, 1)


def weave() -> Grey:
    """Wicker: flat strips that go over and under round rods."""
    u, v = 4 * X, 8 * Y
    over = (np.floor(u) + np.floor(v)) % 2
    bulge = np.sin(np.pi * (u % 1)) ** 0.5
    strip = np.sqrt(np.clip(1 - (1.9 * (v % 1 - 0.5)) ** 2, 0, 1))
    return np.clip(0.30 + 0.68 * strip * np.where(over == 0, bulge, 0.55) - 0.03 * noise(121, 0.6), 0, 1)


def leaf() -> Grey:
    """Foliage: leaves over leaves, each of one tone with a light rib."""
    dice = np.random.default_rng(131)
    grey = np.full((TEXTURE_SIZE, TEXTURE_SIZE), 0.35)
    for place, turn, tone in zip(dice.random((260, 2)), dice.uniform(0, np.pi, 260), dice.random(260), strict=True):
        dx, dy = ((X - place[0] + 0.5) % 1 - 0.5), ((Y - place[1] + 0.5) % 1 - 0.5)
        along, across = dx * np.cos(turn) + dy * np.sin(turn), dy * np.cos(turn) - dx * np.sin(turn)
        inside = np.abs(across) < 0.028 * (1 - (along / 0.08) ** 2)
        grey = np.where(inside, 0.5 + 0.45 * tone + 0.1 * (np.abs(across) < 0.003), grey)
    return np.clip(grey, 0, 1)


def concrete() -> Grey:
    """Cloudy grey with small pores."""
    pores = soft(noise(142, 0.5, least=20) - 2.4, 0.3)
    return np.clip(0.86 + 0.05 * noise(141, 1.6) - 0.4 * pores, 0, 1)


def asphalt() -> Grey:
    """Dark tar with light grit."""
    return np.clip(0.62 + 0.11 * noise(151, 0.2) + 0.3 * soft(noise(152, 0.3, least=24) - 2.2, 0.4), 0, 1)


def grass() -> Grey:
    """Blades that stand up, light tips over dark ground."""
    return level(noise(161, 0.7, across=0.3, least=4) + 0.3 * noise(162, 2.0), 0.4, 1.0)


IMAGES: dict[str, Callable[[], Grey]] = {
    f"{make.__name__}.png": make
    for make in (
        wood, marble, stone, metal, fabric, rubber, glass, checker, stripes, brick, tiles, planks, carpet, leather,
        paper, weave, leaf, concrete, asphalt, grass,
    )
}  # fmt: skip


def image(name: str) -> NDArray[np.uint8]:
    """Return the texels of an image."""
    return np.rint(255 * np.clip(IMAGES[name](), 0, 1)).astype(np.uint8)


def current(name: str) -> bool:
    """Whether the file is current."""
    if not (TEXTURES / name).is_file():
        return False
    there = np.asarray(Image.open(TEXTURES / name)).astype(int)
    return there.shape == (TEXTURE_SIZE, TEXTURE_SIZE) and int(np.abs(there - image(name)).max()) <= TOLERANCE


def main(*arguments: str) -> int:
    """Write or check the images."""
    stale = [name for name in IMAGES if not current(name)]
    for name in stale:
        print(TEXTURES / name)
        if "--check" not in arguments:
            Image.fromarray(image(name)).save(TEXTURES / name, optimize=True)
    return int(bool(stale) and "--check" in arguments)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
