"""Types of values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from wmspec.lang.check.types.units import ANGLE, LENGTH, NUMBER, TIME, Dimension


@dataclass(frozen=True)
class Quantity:
    """A number with a dimension."""

    dimension: Dimension

    def __str__(self) -> str:
        return str(self.dimension)


@dataclass(frozen=True)
class Word:
    """A word of a vocabulary, such as a shape or a colour."""

    vocabulary: str

    def __str__(self) -> str:
        return self.vocabulary


@dataclass(frozen=True)
class Plain:
    """A type without parameters: a truth value, a text, a kind of entity, a picture, a place, a label."""

    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class List:
    """A list of values of one type; `None` for the empty list."""

    item: Type | None

    def __str__(self) -> str:
        if isinstance(self.item, Vector):
            return f"list of {self.item.plural}"
        return f"list of {self.item}s" if self.item else "empty list"


@dataclass(frozen=True)
class Vector:
    """Two or three quantities of one dimension: a point, a size, a direction."""

    dimension: Dimension
    size: int

    def __str__(self) -> str:
        return f"{self._tuple} of {self._parts}"

    @property
    def plural(self) -> str:
        """The plural, for messages."""
        return f"{self._tuple}s of {self._parts}"

    @property
    def _tuple(self) -> str:
        return "pair" if self.size == 2 else "triple"

    @property
    def _parts(self) -> str:
        return {LENGTH: "lengths", NUMBER: "plain numbers", ANGLE: "angles"}.get(
            self.dimension, f"values ({self.dimension})"
        )


Type = Quantity | Word | Plain | List | Vector

TRUTH = Plain("truth value")
TEXT = Plain("text")
OBJECT = Plain("object")
CAMERA = Plain("camera")
ACTION = Plain("action")
PICTURE = Plain("picture")
PART = Plain("part")
JOINT = Plain("joint")
ROBOT = Plain("robot")
LIGHT = Plain("light")
WORLD = Plain("world")
#: The answer to whether an episode is possible.
POSSIBILITY = Plain("possibility")
#: In function signatures: a quantity of any dimension, the same throughout the signature.
QUANTITY = Plain("quantity")
#: In function parameters: objects to count, or truth values of which the true ones are counted.
COUNTED = Plain("list of objects or truth values")
#: In function options: a viewpoint.
VIEWER = Plain("camera or object")
#: A location relative to another object: a point on the ground that is no pair of numbers.
PLACE = Plain("place")
#: An object, a text or `neither`: types that may be mixed among the options of one question.
LABEL = Plain("label")
#: In function signatures: the item type of a list.
ITEM = Plain("item")
COLOR = Word("color")
SHAPE = Word("shape")
MATERIAL = Word("material")
COLLISION = Word("collision")
UNITS = Word("units")
UP = Word("up")
INERTIA_SOURCE = Word("inertia")
DIRECTION = Word("direction")
PATH = Word("path")
RELATION = Word("relation")
NEITHER = Word("tie")
CHANNEL = Word("channel")
A_NUMBER = Quantity(NUMBER)
A_LENGTH = Quantity(LENGTH)
A_TIME = Quantity(TIME)
AN_ANGLE = Quantity(ANGLE)
POINT2 = Vector(LENGTH, 2)
POINT3 = Vector(LENGTH, 3)
TRIPLE = Vector(NUMBER, 3)
TURNS = Vector(ANGLE, 3)


def either(words: Sequence[str]) -> str:
    """Return `a, b or c`, for messages."""
    return " or ".join([*([", ".join(words[:-1])] if len(words) > 1 else []), *words[-1:]])


def article(noun: str) -> str:
    """Return the noun with `a` or `an`, for messages."""
    return f"{'an' if noun[0] in 'aeio' else 'a'} {noun}"
