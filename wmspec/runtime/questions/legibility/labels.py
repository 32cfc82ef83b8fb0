"""Measures of questions whose options are words, and of open numbers: what decides between them, as drawn."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from wmspec.compile.layout.cavities import clearance
from wmspec.compile.layout.geometry import volume
from wmspec.core.memoize import cached_on
from wmspec.lang.check.ir.evaluate import Environment, evaluate
from wmspec.lang.check.ir.ir import Call, Expr, Items, Operation, Property, Ref, TaskSpec
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.runtime.questions.difference import lab_of_bytes
from wmspec.runtime.questions.legibility.bounds import BOUNDS, entry, ratio
from wmspec.runtime.questions.legibility.color_vision import difference
from wmspec.runtime.questions.legibility.motion import aim_gap, camera_times, lead
from wmspec.runtime.questions.legibility.picture_places import center, pixels_per_metre, size
from wmspec.runtime.questions.measure import Measured
from wmspec.runtime.questions.model import Legibility
from wmspec.runtime.questions.motion import moving_time
from wmspec.runtime.questions.observed import Observed
from wmspec.runtime.questions.patch import patch
from wmspec.runtime.questions.question_context import QuestionContext
from wmspec.sim.scene.model import Array, Frame

#: Quantiles at which two distributions of lightness are compared.
_QUANTILES = np.linspace(0.05, 0.95, 19)

#: Functions that compare movers, by how far each gets.
_RACES = frozenset({"fastest", "slowest", "mover", "first"})
#: Functions with lengths that a picture shows.
_LENGTHS = frozenset({"distance", "height", "extension", "position"})
_ORDERS = frozenset({"<", "<=", ">", ">="})


@dataclass(frozen=True)
class DecisiveMeasures:
    """Measures of everything that decides the answer of a question.

    `shown` is whether pictures show the end of the episode, so that states at the end are seen, not predicted.
    """

    asking: QuestionContext
    shown: bool

    @cached_property
    def env(self) -> Measured:
        """An environment of its own, so that nothing is added to the measured values of the row."""
        return self.asking.measure(self.asking.run, self.asking.observed)

    @property
    def observed(self) -> Observed:
        """The observations of the true run."""
        return self.asking.observed

    @cached_property
    def frames(self) -> tuple[Frame, ...]:
        """The shown pictures."""
        return tuple(self.observed.picture(*view) for view in self.observed.views)

    @cached_property
    def parts(self) -> tuple[Expr, ...]:
        """The subexpressions that decide the answer."""
        return tuple(decisive_parts(self.asking.question.answer, self.asking.values.spec, self.env))

    def all(self) -> Iterator[Legibility]:
        """Yield every applicable measure, several times if there are several comparisons."""
        for part in self.parts:
            match part:
                case Call(each=None) if part.function in FUNCTIONS:
                    yield from self._call(part.function, [evaluate(a, self.env) for a in part.arguments], part)
                case Operation(operator="==" | "!=", operands=(Property() as a, Property() as b)):
                    yield from self._equal(a, b)
                case Operation(each=None) if part.operator in _ORDERS:
                    yield from self._ordered(part)

    # ------------------------------------------------------------ calls

    def _call(self, function: str, arguments: Sequence[Any], call: Call) -> Iterator[Legibility]:
        match function, arguments:
            case _, [tuple() as names] if function in _RACES:
                yield from self._race(names, evaluate(call, self.env))
            case "longest", [tuple() as names]:
                yield from self._durations(names, evaluate(call, self.env))
            case "largest" | "smallest", [tuple() as names]:
                yield from self._sizes(names, evaluate(call, self.env))
            case "darkest" | "lightest", [tuple() as names]:
                chosen = evaluate(call, self.env)
                yield from self._colors((chosen, name) for name in names if chosen in names and name != chosen)
            case "relation", [str() as a, str() as b]:
                yield from self._apart(a, b)
            case "heads_to", [str() as name, tuple() as others]:
                yield entry("place", aim_gap(self.observed, name, others))
            case "fits", [str() as owner, str() as container]:
                room = clearance(self.asking.values, owner, container)
                yield entry("length", abs(room) * self._pixels_per_metre(owner))
            case "count", [tuple() as items]:
                yield entry("number", evaluate(call, self.env))
                if counted := [name for name in items if isinstance(name, str) and self._counts(name)]:
                    yield self.size(counted)

    def _race(self, names: Sequence[str], chosen: str) -> Iterator[Legibility]:
        """Yield how far the chosen one gets from the others; for a tie nothing decides."""
        if chosen in names and camera_times(self.observed) and len(names) > 1:
            yield entry("lead", min(lead(self.observed, chosen, name) for name in names if name != chosen))

    def _durations(self, names: Sequence[str], chosen: str) -> Iterator[Legibility]:
        times = next(iter(camera_times(self.observed).values()), ())
        if chosen in names and times and len(names) > 1:
            every = (times[-1] - times[0]) / (len(times) - 1)
            own = moving_time(self.observed, chosen)
            gaps = [abs(own - moving_time(self.observed, name)) for name in names if name != chosen]
            yield entry("intervals", min(gaps) / every)

    def _sizes(self, names: Sequence[str], chosen: str) -> Iterator[Legibility]:
        """Yield the difference of true sizes, drawn at the place of the chosen object."""
        if chosen in names and len(names) > 1:
            own = volume(self.asking.values, chosen)
            ratios = [volume(self.asking.values, name) / own for name in names if name != chosen]
            change = min(abs(1 - each ** (1 / 3)) for each in ratios)
            yield entry("length", change * self._best_size(chosen))

    def _apart(self, a: str, b: str) -> Iterator[Legibility]:
        patches = self._patches(a, b)
        if not patches and self._may_hide(a, b):
            return
        gaps = [0.0]
        for frame, i, j in patches:
            here, there = center(frame, i), center(frame, j)
            assert here is not None and there is not None  # noqa: PT018
            gaps.append(float(np.linalg.norm(here - there)))
        yield entry("place", max(gaps))

    # ------------------------------------------------------------ operators

    def _equal(self, a: Property, b: Property) -> Iterator[Legibility]:
        """Yield the drawn difference of two colours or materials that differ."""
        names = evaluate(a.owner, self.env), evaluate(b.owner, self.env)
        if a.name != b.name or evaluate(a, self.env) == evaluate(b, self.env) or names[0] == names[1]:
            return
        if a.name == "color":
            yield from self._colors([names])
        elif a.name == "material":
            yield from self._materials(*names)

    def _ordered(self, part: Operation) -> Iterator[Legibility]:
        """Yield the difference of two compared lengths or speeds of objects."""
        calls = [
            (each.function, tuple(evaluate(a, self.env) for a in each.arguments))
            for operand in part.operands
            for each in decisive_parts(operand, self.asking.values.spec, self.env)
            if isinstance(each, Call) and each.function in FUNCTIONS and FUNCTIONS[each.function].measured
        ]
        functions, names = {name for name, _ in calls}, list(dict.fromkeys(a[0] for _, a in calls if a))
        if functions == {"speed"} and len(names) == 2 and camera_times(self.observed):
            yield entry("lead", lead(self.observed, *names))
        elif functions and functions <= _LENGTHS and self.shown and not any(isinstance(n, tuple) for n in names):
            a, b = (evaluate(operand, self.env) for operand in part.operands)
            yield entry("length", abs(a - b) * max(map(self._pixels_per_metre, names)))

    # ------------------------------------------------------------ what is drawn

    def size(self, names: Iterable[str]) -> Legibility:
        """Return the size of the smallest of these bodies, each in the picture that shows it largest."""
        return entry("size", *min((self._best_size(name), name) for name in names))

    def _best_size(self, name: str) -> float:
        index = self.observed.index(name)
        return max(size(frame, index) for frame in self.frames)

    def _pixels_per_metre(self, name: str) -> float:
        return max(pixels_per_metre(self.observed, name, view) for view in self.observed.views)

    def _counts(self, name: str) -> bool:
        """Whether a thing counted must be large enough: it is present, and shown unless it may be hidden."""
        present = any(body.name == name for body in self.observed.scene.bodies)
        return present and (not self._may_hide(name) or self._best_size(name) > 0)

    def _may_hide(self, *names: str) -> bool:
        return any(map(self.asking.declared.declares, names))

    def _patches(self, a: str, b: str) -> list[tuple[Frame, int, int]]:
        """Return the pictures that show two bodies, and their indices."""
        i, j = self.observed.index(a), self.observed.index(b)
        return [(f, i, j) for f in self.frames if patch(f, i).pixels and patch(f, j).pixels]

    def _colors(self, pairs: Iterable[tuple[str, str]]) -> Iterator[Legibility]:
        for a, b in pairs:
            yield entry("color", self._color_gap(a, b))

    def _color_gap(self, a: str, b: str) -> float:
        """Return the difference of the mean colours of two bodies, in the picture that shows it best."""
        colors = [(patch(frame, i).color, patch(frame, j).color) for frame, i, j in self._patches(a, b)]
        return max((difference(p, q) for p, q in colors if p is not None and q is not None), default=0.0)

    def _materials(self, a: str, b: str) -> Iterator[Legibility]:
        """Yield the difference of mean colours, or of the grain if that is greater."""
        color = self._color_gap(a, b)
        texture = max((texture_difference(*seen) for seen in self._patches(a, b)), default=0.0)
        yield entry("material", color) if color >= texture else entry("texture", texture)


def least_by_name(measures: Iterable[Legibility]) -> tuple[Legibility, ...]:
    """Return the least legible measure of each name, in the order of the table."""
    worst: dict[str, Legibility] = {}
    for each in measures:
        if each.name not in worst or ratio(each) < ratio(worst[each.name]):
            worst[each.name] = each
    return tuple(worst[name] for name in BOUNDS if name in worst)


def texture_difference(frame: Frame, a: int, b: int) -> float:
    """Return the difference (L*) of two bodies in a picture in the spread or in the grain of lightness, if larger.

    The spread is the distribution about the median, the grain that of steps between neighbouring pixels. Distributions
    are compared by the mean difference of their quantiles (Wasserstein distance).
    """
    one, other = cached_on(frame, _distributions, a), cached_on(frame, _distributions, b)
    return float(np.abs(one - other).mean(axis=1).max())


def _distributions(frame: Frame, index: int) -> Array:
    """Return the quantiles (2, q) of the lightness of a body about its median, and of its steps; 0 if not drawn."""
    mask = frame.ids == index
    light = lab_of_bytes(frame.rgb)[..., 0]
    steps = np.concatenate(
        [
            np.abs(light[1:] - light[:-1])[mask[1:] & mask[:-1]],
            np.abs(light[:, 1:] - light[:, :-1])[mask[:, 1:] & mask[:, :-1]],
        ]
    )
    spread = light[mask] - np.median(light[mask]) if mask.any() else np.zeros(1)
    return np.stack([np.quantile(each, _QUANTILES) for each in (spread, steps if len(steps) else np.zeros(1))])


def decisive_parts(expr: Expr, spec: TaskSpec, env: Environment) -> Iterator[Expr]:
    """Yield an expression and the subexpressions that are evaluated for its value, named values included.

    Branches of `if`, and operands of `and` and `or`, that are not evaluated do not count.
    """
    lets = {let.name: let.value for let in spec.lets}
    return _parts(expr, lets, env, set())


def _parts(expr: Expr, lets: Mapping[str, Expr], env: Environment, seen: set[str]) -> Iterator[Expr]:
    yield expr
    for part in _evaluated(expr, lets, env, seen):
        yield from _parts(part, lets, env, seen)


def _evaluated(expr: Expr, lets: Mapping[str, Expr], env: Environment, seen: set[str]) -> Iterator[Expr]:
    """Yield the direct subexpressions that are evaluated."""
    match expr:
        case Ref() if expr.name in lets and expr.name not in seen:
            seen.add(expr.name)
            yield lets[expr.name]
        case Property():
            yield expr.owner
        case Items():
            yield from expr.items
        case Call():
            yield from expr.arguments
        case Operation(operator="if", each=None):
            condition, then, otherwise = expr.operands
            yield condition
            yield then if evaluate(condition, env) else otherwise
        case Operation(operator="and" | "or", each=None):
            for operand in expr.operands:
                yield operand
                if bool(evaluate(operand, env)) == (expr.operator == "or"):
                    return
        case Operation():
            yield from expr.operands
