"""Units and dimensions. Checked values are SI numbers; there are no unit objects at run time."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

from wmspec.core.spelling import closest_word


@dataclass(frozen=True)
class Dimension:
    """Exponents of length, mass, time and angle."""

    length: int = 0
    mass: int = 0
    time: int = 0
    angle: int = 0

    def __mul__(self, other: Dimension) -> Dimension:
        return Dimension(
            self.length + other.length, self.mass + other.mass, self.time + other.time, self.angle + other.angle
        )

    def __truediv__(self, other: Dimension) -> Dimension:
        return self * other**-1

    def __pow__(self, n: int) -> Dimension:
        return Dimension(self.length * n, self.mass * n, self.time * n, self.angle * n)

    def __str__(self) -> str:
        return _NAMES.get(self) or self.symbol

    @property
    def symbol(self) -> str:
        """The SI unit, such as `kg*m/s^2`; '' for a plain number."""
        parts = [("kg", self.mass), ("m", self.length), ("rad", self.angle), ("s", self.time)]
        above = "*".join(u if n == 1 else f"{u}^{n}" for u, n in parts if n > 0)
        below = "/".join(u if n == -1 else f"{u}^{-n}" for u, n in parts if n < 0)
        return f"{above or '1'}/{below}" if below else above


NUMBER = Dimension()
LENGTH = Dimension(length=1)
MASS = Dimension(mass=1)
TIME = Dimension(time=1)
ANGLE = Dimension(angle=1)
SPEED = LENGTH / TIME
ACCELERATION = SPEED / TIME
ANGULAR_SPEED = ANGLE / TIME
DENSITY = MASS / LENGTH**3
FORCE = MASS * ACCELERATION
IMPULSE = MASS * SPEED
VOLUME = LENGTH**3
INERTIA = MASS * LENGTH**2

_NAMES = {
    NUMBER: "plain number",
    LENGTH: "length",
    MASS: "mass",
    TIME: "time",
    ANGLE: "angle",
    SPEED: "speed",
    ACCELERATION: "acceleration",
    ANGULAR_SPEED: "angular speed",
    DENSITY: "density",
    FORCE: "force",
    IMPULSE: "impulse",
    LENGTH**2: "area",
    VOLUME: "volume",
    NUMBER / TIME: "frequency",
    INERTIA: "moment of inertia",
}

#: Example values by dimension, for messages.
EXAMPLES = {
    LENGTH: "6 cm",
    MASS: "200 g",
    TIME: "0.5 s",
    ANGLE: "30 deg",
    SPEED: "20 cm/s",
    ACCELERATION: "9.81 m/s^2",
    ANGULAR_SPEED: "90 deg/s",
    DENSITY: "700 kg/m^3",
    FORCE: "2 N",
    IMPULSE: "0.1 N*s",
    INERTIA: "0.1 kg*m^2",
    NUMBER: "0.5",
}

#: Display units by dimension, each with its lower bound (SI).
_DISPLAY_UNITS = {
    LENGTH: (("km", 1000.0), ("m", 1.0), ("cm", 0.01), ("mm", 0.0)),
    MASS: (("kg", 1.0), ("g", 0.0)),
    TIME: (("s", 0.0),),
    ANGLE: (("deg", 0.0),),
    SPEED: (("m/s", 1.0), ("cm/s", 0.0)),
    ANGULAR_SPEED: (("deg/s", 0.0),),
    FORCE: (("N", 0.0),),
    IMPULSE: (("N*s", 0.0),),
    VOLUME: (("m^3", 1.0), ("cm^3", 0.0)),
    NUMBER / TIME: (("Hz", 0.0),),
}

UNITS: dict[str, tuple[float, Dimension]] = {
    "mm": (1e-3, LENGTH),
    "cm": (1e-2, LENGTH),
    "dm": (1e-1, LENGTH),
    "m": (1.0, LENGTH),
    "km": (1e3, LENGTH),
    "mg": (1e-6, MASS),
    "g": (1e-3, MASS),
    "kg": (1.0, MASS),
    "t": (1e3, MASS),
    "ms": (1e-3, TIME),
    "s": (1.0, TIME),
    "min": (60.0, TIME),
    "h": (3600.0, TIME),
    "Hz": (1.0, NUMBER / TIME),
    "rad": (1.0, ANGLE),
    "deg": (math.pi / 180, ANGLE),
    "turn": (2 * math.pi, ANGLE),
    "N": (1.0, FORCE),
    "frames": (1.0, NUMBER),
    "frame": (1.0, NUMBER),
    "%": (0.01, NUMBER),
}

_FACTOR = re.compile(r"([*/]?)([A-Za-z]+|%)(?:\^(-?\d+))?")


class UnknownUnit(Exception):
    """Unknown unit; the argument is its name as written."""


#: Foreign units and spellings: factor and equivalent unit.
FOREIGN_UNITS: dict[str, tuple[float, str]] = {
    **dict.fromkeys(("inch", "inches"), (2.54, "cm")),
    **dict.fromkeys(("ft", "foot", "feet"), (30.48, "cm")),
    **dict.fromkeys(("yd", "yard", "yards"), (91.44, "cm")),
    **dict.fromkeys(("mi", "mile", "miles"), (1.609344, "km")),
    **dict.fromkeys(("lb", "lbs", "pound", "pounds"), (453.59237, "g")),
    **dict.fromkeys(("oz", "ounce", "ounces"), (28.349523, "g")),
    **dict.fromkeys(("um", "micron", "microns"), (0.001, "mm")),
    **dict.fromkeys(("millimeter", "millimeters", "millimetre", "millimetres"), (1, "mm")),
    **dict.fromkeys(("centimeter", "centimeters", "centimetre", "centimetres"), (1, "cm")),
    **dict.fromkeys(("meter", "meters", "metre", "metres"), (1, "m")),
    **dict.fromkeys(("kilometer", "kilometers", "kilometre", "kilometres"), (1, "km")),
    **dict.fromkeys(("gram", "grams", "gramme", "grammes"), (1, "g")),
    **dict.fromkeys(("kilogram", "kilograms", "kilo", "kilos", "kgs", "Kg", "KG"), (1, "kg")),
    **dict.fromkeys(("ton", "tons", "tonne", "tonnes"), (1, "t")),
    **dict.fromkeys(("sec", "secs", "second", "seconds"), (1, "s")),
    **dict.fromkeys(("msec", "msecs", "millisecond", "milliseconds"), (1, "ms")),
    **dict.fromkeys(("us", "usec", "microsecond", "microseconds"), (0.001, "ms")),
    **dict.fromkeys(("mins", "minute", "minutes"), (1, "min")),
    **dict.fromkeys(("hr", "hrs", "hour", "hours"), (1, "h")),
    **dict.fromkeys(("degree", "degrees", "degs"), (1, "deg")),
    **dict.fromkeys(("radian", "radians", "rads"), (1, "rad")),
    **dict.fromkeys(("turns", "rev", "revs", "revolution", "revolutions"), (1, "turn")),
    **dict.fromkeys(("rpm",), (1, "turn/min")),
    **dict.fromkeys(("mph",), (0.44704, "m/s")),
    **dict.fromkeys(("kph", "kmh", "kmph"), (1, "km/h")),
    **dict.fromkeys(("mps",), (1, "m/s")),
    **dict.fromkeys(("fps",), (30.48, "cm/s")),
    **dict.fromkeys(("newton", "newtons"), (1, "N")),
    **dict.fromkeys(("hertz", "hz", "HZ"), (1, "Hz")),
    **dict.fromkeys(("percent", "pct"), (1, "%")),
    **dict.fromkeys(("J", "joule", "joules"), (1, "N*m")),
    **dict.fromkeys(("lbf",), (4.448222, "N")),
}


def remedy(unknown: str, text: str, expected: Iterable[Dimension]) -> str:
    """Return the remedy for an unknown unit in a text such as `8 inch`; among equals, an expected dimension wins."""
    if unknown in FOREIGN_UNITS:
        scale, unit = FOREIGN_UNITS[unknown]
        match = re.fullmatch(r"([\d.]+(?:[eE][+-]?\d+)?)\s*(.+)", text)
        if match and match[2] == unknown:
            return f"write `{float(match[1]) * scale:.6g} {unit}`"
        return f"write `{unit}`" if scale == 1 else f"1 {unknown} is {scale:g} {unit}"
    dimensions = set(expected)
    fitting = [name for name, (_, dimension) in UNITS.items() if dimension in dimensions]
    close = closest_word(unknown, fitting, ("cm", "m", "s", "deg", "kg", "g", "N"), UNITS)
    return f"did you mean `{close}`?" if close else "the units are mm, cm, m, g, kg, ms, s, deg, N and others"


@lru_cache(maxsize=256)
def parse_unit(text: str) -> tuple[float, Dimension]:
    """Return the SI value and dimension of a unit such as `cm/s` or `kg*m^2`. Raises UnknownUnit."""
    scale, dimension = 1.0, NUMBER
    for sign, name, power in _FACTOR.findall(text):
        if name not in UNITS:
            raise UnknownUnit(name)
        n = int(power or 1) * (-1 if sign == "/" else 1)
        if abs(n) > 9:
            raise UnknownUnit(f"{name}^{power}")
        unit, unit_dimension = UNITS[name]
        scale, dimension = scale * unit**n, dimension * unit_dimension**n
    return scale, dimension


def parse_quantity(text: str, unit: str, dimension: Dimension) -> float | None:
    """Return the SI value of a text such as `350g`, in `unit` if it names none; None if it is no such quantity."""
    number = text.rstrip("abcdefghijklmnopqrstuvwxyz ")
    try:
        scale, found = parse_unit(text[len(number) :].strip() or unit)
        return float(number) * scale if found == dimension else None
    except (ValueError, UnknownUnit):
        return None


def dimension_named(text: str) -> Dimension:
    """Return the dimension of a name or unit, such as `length` or `kg/s`."""
    return next((dimension for dimension, name in _NAMES.items() if name == text), None) or parse_unit(text)[1]


def format_quantity(value: float, dimension: Dimension) -> str:
    """Return an SI value with its customary unit, such as `-5 cm` or `30 deg`."""
    small = 0.1 if dimension == LENGTH else 0.0  # zero is shown in cm
    least = abs(value) or small
    unit = next((u for u, from_ in _DISPLAY_UNITS.get(dimension, ()) if least >= from_ * (1 - 1e-9)), dimension.symbol)
    number = value / parse_unit(unit)[0] if unit else value
    return f"{number + 0.0:.6g} {unit}".rstrip()  # turns -0.0 into 0.0


def units_of(dimension: Dimension) -> tuple[str, ...]:
    """Return the units of a dimension: those of the table, then compound ones."""
    plain = [name for name, (_, of) in UNITS.items() if of == dimension]
    made = [unit for unit, _ in _DISPLAY_UNITS.get(dimension, ())]
    made += [EXAMPLES[dimension].partition(" ")[2]] if dimension in EXAMPLES else []
    return tuple(dict.fromkeys(filter(None, (*plain, *made, dimension.symbol))))


def convert(value: float, scale: float) -> float:
    """Return `value * scale`, rounded correctly if the scale is the inverse of an integer (35 cm is exactly 0.35 m)."""
    inverse = round(1 / scale)
    return value / inverse if inverse > 1 and abs(inverse * scale - 1) < 1e-12 else value * scale
