"""What the language knows about the world: words, properties, verbs and functions, as tables.

Everything here is data: the checker reads it, and so do the messages and the reference documentation.
"""

from __future__ import annotations

from dataclasses import dataclass

from wmspec.check.kinds import (
    A_LENGTH,
    A_NUMBER,
    A_TIME,
    AN_ANGLE,
    CAMERA,
    COLOR,
    OBJECT,
    PICTURE,
    POINT2,
    POINT3,
    SHAPE,
    TEXT,
    TRIPLE,
    TRUTH,
    Kind,
    List,
    Quantity,
)
from wmspec.check.units import ACCELERATION, DENSITY, MASS, SPEED

#: sRGB in 0..1. Told apart at a glance, named as a person would name them.
COLORS: dict[str, tuple[float, float, float]] = {
    "red": (0.80, 0.12, 0.12),
    "orange": (0.93, 0.50, 0.10),
    "yellow": (0.92, 0.80, 0.12),
    "green": (0.13, 0.58, 0.22),
    "cyan": (0.15, 0.70, 0.78),
    "blue": (0.12, 0.27, 0.80),
    "purple": (0.50, 0.18, 0.64),
    "pink": (0.93, 0.52, 0.68),
    "brown": (0.42, 0.26, 0.14),
    "white": (0.95, 0.95, 0.93),
    "gray": (0.50, 0.50, 0.50),
    "black": (0.08, 0.08, 0.09),
    "oak": (0.68, 0.52, 0.36),
    "walnut": (0.40, 0.29, 0.21),
    "sand": (0.80, 0.76, 0.68),
    "slate": (0.46, 0.50, 0.54),
    "plaster": (0.74, 0.73, 0.71),
    "chalk": (0.90, 0.89, 0.87),
    "mist": (0.86, 0.90, 0.95),
}

WORDS: dict[str, tuple[str, ...]] = {
    "shape": ("box", "cube", "sphere", "cylinder", "cone", "capsule"),
    "color": tuple(COLORS),
}


@dataclass(frozen=True)
class Slot:
    """A property or argument: the kinds it takes, its bounds, the value it has when left out, and what it means.

    `default` is the text of an expression; None means that it must be given unless `optional`.
    """

    kinds: tuple[Kind, ...]
    meaning: str
    default: str | None = None
    optional: bool = False
    above: float | None = None
    least: float | None = None
    most: float | None = None

    def fault(self, value: float) -> str:
        """What a value must be and is not, such as `more than 0`; empty if it is within bounds."""
        if self.above is not None and value <= self.above:
            return f"more than {self.above:g}"
        if self.least is not None and value < self.least:
            return f"at least {self.least:g}"
        if self.most is not None and value > self.most:
            return f"at most {self.most:g}"
        return ""


PROPERTIES: dict[str, dict[str, Slot]] = {
    "object": {
        "shape": Slot((SHAPE,), "its form", "cube"),
        "size": Slot((A_LENGTH, POINT3), "edge or diameter and height; for a box, its three edges", "10 cm", above=0),
        "radius": Slot((A_LENGTH,), "of a round object, instead of half its size", optional=True, above=0),
        "height": Slot((A_LENGTH,), "of a cylinder, cone or capsule, instead of its size", optional=True, above=0),
        "color": Slot((COLOR,), "its colour", "gray"),
        "roughness": Slot((A_NUMBER,), "of its surface, 0 is a mirror", "0.6", least=0, most=1),
        "metallic": Slot((A_NUMBER,), "1 for bare metal", "0", least=0, most=1),
        "mass": Slot((Quantity(MASS),), "its mass, instead of its density", optional=True, above=0),
        "density": Slot((Quantity(DENSITY),), "its mass per volume", "600 kg/m^3", above=0),
        "friction": Slot((A_NUMBER,), "friction; a touching pair has the geometric mean", "0.5", least=0, most=5),
        "restitution": Slot((A_NUMBER,), "bounciness; a touching pair has the geometric mean", "0.1", least=0, most=1),
        "on": Slot((OBJECT,), "what it rests on; `on: table at (x, y)` says where, from its middle", optional=True),
        "at": Slot((POINT2, POINT3), "where its middle is: (x, y) on what it rests on, else (x, y, z)", "(0 m, 0 m)"),
        "yaw": Slot((AN_ANGLE,), "how far it is turned about the vertical, anticlockwise from above", "0 deg"),
        "fixed": Slot((TRUTH,), "whether it can never move", "false"),
        "solid": Slot((TRUTH,), "whether it can be touched; a mark on the floor cannot, and must be fixed", "true"),
    },
    "camera": {
        "at": Slot((POINT3,), "where it is"),
        "look_at": Slot((POINT3,), "what it looks at", "(0 m, 0 m, 0 m)"),
        "fov": Slot((AN_ANGLE,), "its vertical field of view", "40 deg", above=0, most=2.6),
    },
    "light": {
        "direction": Slot((TRIPLE,), "where its light goes", "(0.35, 0.45, -1)"),
        "diffuse": Slot((A_NUMBER,), "how much light comes from the sun", "0.65", least=0, most=2),
        "ambient": Slot((A_NUMBER,), "how much light comes from everywhere", "0.35", least=0, most=2),
    },
    "world": {
        "gravity": Slot((Quantity(ACCELERATION),), "downwards", "9.81 m/s^2", least=0),
        "background": Slot((COLOR,), "what is seen where nothing is", "mist"),
    },
}  # fmt: skip


@dataclass(frozen=True)
class Verb:
    """An action's verb: its arguments in order. `start` and `duration` come from the timings `at`, `for`, ..."""

    meaning: str
    arguments: dict[str, Slot]
    lasts: bool


_DIRECTION = Slot((AN_ANGLE,), "heading on the ground, anticlockwise from +x; or `toward(object)`")

VERBS: dict[str, Verb] = {
    "launch": Verb(
        "gives the object a velocity, as a sudden push would",
        {
            "object": Slot((OBJECT,), "what is launched"),
            "direction": _DIRECTION,
            "speed": Slot((Quantity(SPEED),), "how fast it sets off", least=0, most=100),
            "rolling": Slot((TRUTH,), "whether a round object sets off rolling instead of sliding", "false"),
        },
        lasts=False,
    ),
    "glide": Verb(
        "carries the object along a straight line at constant speed, whatever is in its way",
        {
            "object": Slot((OBJECT,), "what is carried"),
            "direction": _DIRECTION,
            "speed": Slot((Quantity(SPEED),), "how fast it goes", least=0, most=100),
        },
        lasts=True,
    ),
}


@dataclass(frozen=True)
class Function:
    """A function: its parameters, its result, and whether it is measured on the executed episode."""

    meaning: str
    parameters: tuple[Kind, ...]
    result: Kind
    measured: bool


FUNCTIONS: dict[str, Function] = {
    "toward": Function("the heading from the acting object to another", (OBJECT,), AN_ANGLE, False),
    "opposite": Function("the heading the other way", (AN_ANGLE,), AN_ANGLE, False),
    "rgb": Function("a colour by its sRGB parts, 0 to 1", (A_NUMBER, A_NUMBER, A_NUMBER), COLOR, False),
    "speed": Function("distance travelled while observed, over that time", (OBJECT,), Quantity(SPEED), True),
    "displacement": Function("how far it is at the end from where it began", (OBJECT,), A_LENGTH, True),
    "distance": Function("between the middles of two objects, at the end", (OBJECT, OBJECT), A_LENGTH, True),
    "contact": Function("whether the two touch at any time", (OBJECT, OBJECT), TRUTH, True),
    "fastest": Function("the one with the largest speed", (List(OBJECT),), OBJECT, True),
    "slowest": Function("the one with the smallest speed", (List(OBJECT),), OBJECT, True),
    "frame": Function("the picture from a camera at a time", (CAMERA, A_TIME), PICTURE, True),
}

SETTINGS: dict[str, Kind] = {
    "title": TEXT,
    "license": TEXT,
    "source": TEXT,
    "repeat": A_NUMBER,
    "horizon": A_TIME,
}

#: Lengths above this (m) are taken for a mistake: engines lose precision there.
MOST_LENGTH = 1e4
