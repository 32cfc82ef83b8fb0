"""Functions of the language that need no executed episode: places, colours, arithmetic, presence."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from wmspec.compile.layout import geometry
from wmspec.compile.layout.cavities import fits
from wmspec.compile.layout.motion import heading_of
from wmspec.compile.layout.surfaces import WORLD
from wmspec.compile.layout.view import gaze_direction, view_coordinates
from wmspec.lang.check.ir.evaluate import NoValue
from wmspec.lang.check.tables import color_math

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

Location = tuple[str, float, float]


def call(values: Evaluator, function: str, arguments: tuple[Any, ...], options: Mapping[str, Any]) -> Any:
    """Return the value of a design function. Raises WmsError if it has none."""
    try:
        return FUNCTIONS[function](values, *arguments, **options)
    except (OverflowError, ValueError, ZeroDivisionError):  # for infinite numbers and empty lists
        raise NoValue(f"`{function}` has no value here") from None


# ---------------------------------------------------------------- places


def _toward(values: Evaluator, subject: str, target: str) -> float:
    (x, y, _), (to_x, to_y, _) = values.pose(subject).position, values.pose(target).position
    return math.atan2(to_y - y, to_x - x)


def _beside(dx: float, dy: float) -> Callable[..., Location]:
    """Return a function for a place at a distance to the right and to the back, seen by the world or a viewer."""

    def beside(values: Evaluator, owner: str, far: float, seen_from: str | None = None) -> Location:
        x, y, _ = values.pose(owner).position
        right, back = (dx, dy) if seen_from is None else view_coordinates(-gaze_direction(values, seen_from), dx, dy)
        return (WORLD, x + right * far, y + back * far)

    return beside


def _polar(values: Evaluator, owner: str, far: float, direction: str | float) -> Location:
    heading = heading_of(direction)
    return _beside(math.cos(heading), math.sin(heading))(values, owner, far)


def _between(values: Evaluator, first: str, second: str) -> Location:
    (x, y, _), (to_x, to_y, _) = values.pose(first).position, values.pose(second).position
    return (WORLD, (x + to_x) / 2, (y + to_y) / 2)


# ---------------------------------------------------------------- sums


def _item(_: Evaluator, items: tuple[Any, ...], number: float) -> Any:
    if number != math.floor(number):
        raise NoValue(f"`pick` takes a whole number, not {number:g}")
    return items[int(number) % len(items)]


def _numbers(given: Iterable[Any]) -> list[float]:
    """Return numbers, with lists of numbers flattened."""
    return [n for item in given for n in (item if isinstance(item, tuple) else (item,))]


def _mod(_values: Evaluator, a: float, b: float) -> float:
    if b == 0:
        raise NoValue("`mod` by 0")
    return float(a) - b * math.floor(a / b)  # also works for directions, which cannot be multiplied


def _extreme(choose: Callable[[list[float]], float]) -> Callable[..., float]:
    def extreme_of(_values: Evaluator, *given: Any) -> float:
        if not (numbers := _numbers(given)):
            raise NoValue("there is none to choose from")
        return choose(numbers)

    return extreme_of


def _sqrt(_values: Evaluator, x: float) -> float:
    if x < 0:
        raise NoValue(f"`sqrt` of {x:g}, which has no root")
    return math.sqrt(x)


_ROUNDING = 1e-6


def _rgb(_values: Evaluator, red: float, green: float, blue: float) -> str:
    for part in (red, green, blue):
        if not -_ROUNDING <= part <= 1 + _ROUNDING:
            raise NoValue(f"`rgb` takes parts from 0 to 1, not {part:g} (of 255, write `120 / 255`)")
    return color_math.color_word((red, green, blue))


# ---------------------------------------------------------------- what is there


def _present(values: Evaluator, objects: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(name for name in objects if values.is_present(name))


def _nth(_values: Evaluator, items: tuple[Any, ...], number: float) -> Any:
    """Return the item with an index; negative indices count from the end."""
    i = int(number)
    if not -len(items) <= i < len(items):
        raise NoValue(f"index {i} is out of range: there are {len(items)} items")
    return items[i]


def _member(_values: Evaluator, members: tuple[Any, ...], number: float) -> Any:
    """Return a member of a set by its index."""
    if number != math.floor(number) or not 0 <= number < len(members):
        raise NoValue(f"index {number:g} is no whole number from 0 to {len(members) - 1}")
    return members[int(number)]


def extreme_name(sizes: dict[str, float], most: bool, tie: float | None = None) -> str:
    """Return the name with the largest or smallest size; the first of equals, or `neither` within `tie` times."""
    ordered = sorted(sizes, key=lambda name: -sizes[name] if most else sizes[name])
    if not ordered:
        raise NoValue("there is none to choose from")
    if tie is not None and len(ordered) > 1:
        low, high = sorted((sizes[ordered[0]], sizes[ordered[1]]))
        if high <= low * tie:
            return "neither"
    return ordered[0]


def _count(values: Evaluator, items: tuple[str | bool, ...]) -> float:
    """Return the number of present objects, or of true values."""
    return float(sum(item if isinstance(item, bool) else values.is_present(item) for item in items))


def _pick(size: Callable[[Evaluator, str], float], most: bool) -> Callable[..., str]:
    def pick(values: Evaluator, objects: tuple[str, ...], tie: float | None = None) -> str:
        return extreme_name({name: size(values, name) for name in objects}, most, tie)

    return pick


def _luminance(values: Evaluator, owner: str) -> float:
    return color_math.luminance(values.text(owner, "color"))


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "toward": _toward,
    "heading_of": lambda _, direction: heading_of(direction),
    "opposite": lambda _, a: heading_of(a) + math.pi,
    "left_of": _beside(-1.0, 0.0),
    "right_of": _beside(1.0, 0.0),
    "in_front_of": _beside(0.0, -1.0),
    "behind": _beside(0.0, 1.0),
    "polar": _polar,
    "between": _between,
    "rgb": _rgb,
    "shade": lambda _, color, share: color_math.shade(color, share),
    "min": _extreme(min),
    "max": _extreme(max),
    "sum": lambda _, *given: math.fsum(_numbers(given)),
    "abs": lambda _, x: abs(x),
    "floor": lambda _, x: float(math.floor(x)),
    "mod": _mod,
    "pick": _item,
    "sqrt": _sqrt,
    "atan": lambda _, x: math.atan(x),
    "sin": lambda _, a: math.sin(a),
    "cos": lambda _, a: math.cos(a),
    "present": _present,
    "nth": _nth,
    "member": _member,
    "count": _count,
    "any": lambda _, truths: any(truths),
    "all": lambda _, truths: all(truths),
    "volume": geometry.volume,
    "largest": _pick(geometry.volume, most=True),
    "smallest": _pick(geometry.volume, most=False),
    "luminance": _luminance,
    "darkest": _pick(_luminance, most=False),
    "lightest": _pick(_luminance, most=True),
    "fits": fits,
}
"""Implementation of each function, given the values and its arguments."""
