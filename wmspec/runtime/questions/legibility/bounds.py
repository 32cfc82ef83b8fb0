"""The bounds of legibility: what a person must be able to see at a glance to answer a question.

Lengths are in pixels of a picture of 384 x 384 that fills 10 degrees, such as 10 cm at 57 cm: 1 px is 1.6 arc minutes.
"""

from __future__ import annotations

from dataclasses import dataclass

from wmspec.runtime.questions.model import Legibility

#: Smaller side (px) of the picture to which all lengths are scaled.
REFERENCE_SIDE = 384


@dataclass(frozen=True)
class Bound:
    """The bound of a measure: its unit and value, what is measured, and where the value comes from.

    A measure must be at least the bound, or at most if `at_most`.
    """

    unit: str
    value: float
    meaning: str
    source: str
    at_most: bool = False


_ACUITY = "acuity of 20/40 resolves 2 arc minutes (ISO 8596)"
_GLANCE = (
    "1 is just noticeable side by side (Sharma, Wu and Dalal 2005); above 5 an observer sees two different colours "
    "(Mokrzycki and Tatol 2011)"
)

#: All measures by name.
BOUNDS: dict[str, Bound] = {
    "step": Bound(
        "px", 12, "the longest path of a mover between two successive pictures of a camera",
        f"{_ACUITY}; 12 px are 19 arc minutes",
    ),
    "step_in_widths": Bound(
        "", 0.25, "the same, in widths of the mover along its path",
        "a choice: pictures are compared by eye, and a smaller shift goes unnoticed within the outline of the mover",
    ),
    "path": Bound(
        "px", 30, "the path of a mover over all shown pictures of a camera",
        "a choice: two and a half steps show direction and speed",
    ),
    "lead": Bound(
        "px", 8, "the difference of the distances of two compared movers from their first places",
        "the just noticeable difference of speeds is 5 % (McKee 1981): 8 px of 160",
    ),
    "intervals": Bound(
        "", 0.9, "the difference of two compared durations, in intervals between pictures",
        "pictures date an event to the interval between two of them; a tenth is allowed for the sampling of motion",
    ),
    "place": Bound(
        "px", 8, "the distance of two places, when the answer depends on which of them it is",
        f"{_ACUITY}; 8 px are 13 arc minutes",
    ),
    "length": Bound(
        "px", 8, "the difference of two compared lengths or sizes, both drawn at the place of the first object",
        "the just noticeable difference of lengths is some per cent (Ono 1967): 8 px of 160 are 5 %",
    ),
    "size": Bound(
        "px", 12, "the size of each object that the question names or counts: the mean of its width and height",
        f"{_ACUITY}; 12 px are 19 arc minutes, nine times that",
    ),
    "number": Bound(
        "", 30, "the number of counted objects",
        "a person counts about 3 things a second (Trick and Pylyshyn 1994): 30 in ten seconds", at_most=True,
    ),
    "color": Bound(
        "ΔE00", 6, "the difference of two drawn colours, when the answer depends on which of them it is", _GLANCE
    ),
    "color_dichromat": Bound(
        "ΔE00", 8, "the difference of two drawn colours that name options, for protanopes and deuteranopes",
        "simulation by Machado, Oliveira and Fernandes (2009); a third more, since colours are named, not compared",
    ),
    "material": Bound("ΔE00", 6, "the difference of the mean colours of two compared materials", _GLANCE),
    "texture": Bound(
        "L*", 6, "the difference of two materials in spread or grain of lightness, where it exceeds that in colour",
        "the same scale: 6 of lightness are a ΔE00 of 4 to 8",
    ),
    "option_place": Bound(
        "px", 8, "the distance by which an object is moved from one option picture to another",
        f"{_ACUITY}; 8 px are 13 arc minutes",
    ),
    "option_color": Bound("ΔE00", 6, "the difference of a colour from one option picture to another", _GLANCE),
    "option_turn": Bound(
        "deg", 30, "how far something is turned from one option picture to another",
        "studies of mental rotation use steps of 20 degrees (Shepard and Metzler 1971)",
    ),
    "option_shape": Bound(
        "", 0.5, "the share of its outline that differs from one option picture to another",
        "a choice: half of the outline",
    ),
}  # fmt: skip


def entry(name: str, value: float, of: str = "") -> Legibility:
    """Return a measured value with its bound, and the object that has it."""
    bound = BOUNDS[name]
    return Legibility(name, bound.unit, float(value), bound.value, of)


def ratio(measured: Legibility) -> float:
    """Return how many times a value meets its bound: 1 or more is legible."""
    if BOUNDS[measured.name].at_most:
        return measured.bound / measured.value if measured.value > 0 else float("inf")
    return measured.value / measured.bound
