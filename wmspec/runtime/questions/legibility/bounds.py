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
    "a difference of 1 is just noticeable side by side (Sharma, Wu and Dalal 2005); above 5, an observer sees two "
    "different colours (Mokrzycki and Tatol 2011)"
)

#: All measures by name.
BOUNDS: dict[str, Bound] = {
    "step": Bound(
        "px", 12, "the longest path of a moving object between two successive pictures of a camera",
        f"{_ACUITY}; 12 px are 19 arc minutes",
    ),
    "step_in_widths": Bound(
        "", 0.25, "the measure `step`, in widths of the moving object along its path",
        "own choice: people compare pictures by eye, and may miss a smaller shift within the outline of the object",
    ),
    "path": Bound(
        "px", 30, "the path of a moving object over all shown pictures of a camera",
        "own choice: two and a half times the bound of `step` shows direction and speed",
    ),
    "lead": Bound(
        "px", 8, "for two moving objects that are compared: the difference of their distances from their first places",
        "people just notice a difference of speeds of 5 % (McKee 1981); over a path of 160 px, these are 8 px",
    ),
    "intervals": Bound(
        "", 0.9, "the difference of two durations that are compared, in intervals between pictures",
        "pictures show the time of an event to within one interval; the bound is a tenth lower to allow for sampling",
    ),
    "place": Bound(
        "px", 8, "the distance between the two places that the question distinguishes",
        f"{_ACUITY}; 8 px are 13 arc minutes",
    ),
    "length": Bound(
        "px", 8, "the difference of two lengths or sizes that are compared, both drawn at the first object's place",
        "people just notice a difference of lengths of a few per cent (Ono 1967); for a length of 160 px, 8 px are 5 %",
    ),
    "size": Bound(
        "px", 12, "the size of each object that the question names or counts: the mean of its width and height",
        f"{_ACUITY}; 12 px are 19 arc minutes, over nine times as much",
    ),
    "number": Bound(
        "", 30, "the number of counted objects",
        "a person counts about 3 objects a second (Trick and Pylyshyn 1994), so 30 objects take ten seconds",
        at_most=True,
    ),
    "color": Bound(
        "ΔE00", 6, "the difference between the two colours, as drawn, that the question distinguishes", _GLANCE
    ),
    "color_dichromat": Bound(
        "ΔE00", 8, "for options that are named by colours: the difference of the two colours, as drawn, for protanopes "
        "and deuteranopes",
        "the simulation of Machado, Oliveira and Fernandes (2009); the bound is a third higher than for `color`, since "
        "people name the colours instead of comparing them",
    ),
    "material": Bound("ΔE00", 6, "the difference of the mean colours of two materials that are compared", _GLANCE),
    "texture": Bound(
        "L*", 6, "the difference of two materials in the spread or the grain of their lightness; it "
        "replaces `material` if it is larger",
        "as for `material`: a difference of 6 in lightness is a ΔE00 of 4 to 8",
    ),
    "option_place": Bound(
        "px", 8, "the distance between the places of an object in two option pictures",
        f"{_ACUITY}; 8 px are 13 arc minutes",
    ),
    "option_color": Bound("ΔE00", 6, "the difference of the colours of an object in two option pictures", _GLANCE),
    "option_turn": Bound(
        "deg", 30, "the rotation of an object between two option pictures",
        "studies of mental rotation use steps of 20 degrees (Shepard and Metzler 1971)",
    ),
    "option_shape": Bound(
        "", 0.5, "the share of an object's outline that differs between two option pictures",
        "own choice: half of the outline must differ",
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
