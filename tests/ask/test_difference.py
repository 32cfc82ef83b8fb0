"""CIEDE2000 gives the published values of Sharma, Wu and Dalal (2005), and sees no difference where there is none."""

from __future__ import annotations

import numpy as np
import pytest

from wmspec.runtime.questions.difference import ciede2000, lab, lab_of_bytes

#: Table 1 of the paper, the pairs that try hue wrap-around, grays and the rotation term.
PAIRS = [
    ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
    ((50.0, -1.3802, -84.2814), (50.0, 0.0, -82.7485), 1.0000),
    ((50.0, 0.0, 0.0), (50.0, -1.0, 2.0), 2.3669),
    ((50.0, 2.49, -0.001), (50.0, -2.49, 0.0009), 7.1792),
    ((50.0, 2.49, -0.001), (50.0, -2.49, 0.0011), 7.2195),
    ((50.0, -0.001, 2.49), (50.0, 0.0011, -2.49), 4.7461),
    ((50.0, 2.5, 0.0), (50.0, 0.0, -2.5), 4.3065),
    ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492),
    ((50.0, 2.5, 0.0), (56.0, -27.0, -3.0), 31.9030),
    ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
    ((22.7233, 20.0904, -46.6940), (23.0331, 14.9730, -42.5619), 2.0373),
    ((90.8027, -2.0831, 1.4410), (91.1528, -1.6435, 0.0447), 1.4441),
    ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
]


@pytest.mark.parametrize(("a", "b", "published"), PAIRS)
def test_the_published_values(a: tuple[float, ...], b: tuple[float, ...], published: float) -> None:
    assert ciede2000(a, b) == pytest.approx(published, abs=1e-4)
    assert ciede2000(b, a) == pytest.approx(published, abs=1e-4)


def test_lab_of_white_gray_and_red() -> None:
    assert lab((1, 1, 1)) == pytest.approx([100, 0, 0], abs=1e-9)
    assert lab((1, 0, 0)) == pytest.approx([53.2408, 80.0925, 67.2032], abs=1e-3)
    assert ciede2000(lab(np.full((3, 3), 0.5)), lab((0.5, 0.5, 0.5))) == pytest.approx(0, abs=1e-9)


def test_colours_of_bytes_are_those_of_numbers() -> None:
    pixels = np.arange(3 * 256, dtype=np.uint16).reshape(-1, 3).astype(np.uint8)
    assert np.array_equal(lab_of_bytes(pixels), lab(pixels / 255.0))
