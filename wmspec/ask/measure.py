"""Measuring on an executed episode: the language's measured functions, as an environment for `evaluate`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from wmspec.check.functions import FUNCTIONS
from wmspec.design.values import Values
from wmspec.scene.model import Trace


class Measured:
    """The values of the spec together with what happened. `window` is the observed time (s), from first to last look.

    `readings` collects every quantity that was measured, by its call as a person would write it.
    """

    def __init__(self, values: Values, trace: Trace, window: tuple[float, float]) -> None:
        self.values = values
        self.trace = trace
        self.window = window
        self.readings: dict[str, float] = {}
        self._bodies = {name: i for i, name in enumerate(trace.bodies)}

    def ref(self, name: str) -> Any:
        """A factor, nuisance, `let` or `end`."""
        return self.values.ref(name)

    def property(self, owner: str, name: str) -> Any:
        """A property of the spec, as it was before the episode."""
        return self.values.property(owner, name)

    def call(self, function: str, arguments: tuple[Any, ...]) -> Any:
        """A measured function, or one of the design."""
        if function not in FUNCTIONS or not FUNCTIONS[function].measured:
            return self.values.call(function, arguments)
        value = _MEASURES[function](self, *arguments)
        if isinstance(value, float | bool):
            self.readings[f"{function}({', '.join(map(str, arguments))})"] = float(value)
        return value

    # ------------------------------------------------------------ measures

    def path(self, body: str) -> Any:
        """The positions (t, 3) of a body in the observed window."""
        first, last = (self.trace.sample(t) for t in self.window)
        return self.trace.position[first : last + 1, self._bodies[body]]

    def speed(self, body: str) -> float:
        """The length of the path in the observed window, over its duration (m/s)."""
        steps = np.diff(self.path(body), axis=0)
        duration = self.window[1] - self.window[0]
        return float(np.linalg.norm(steps, axis=1).sum() / duration) if duration > 0 else 0.0

    def displacement(self, body: str) -> float:
        """How far (m) the body is at the end from where it began."""
        track = self.trace.position[:, self._bodies[body]]
        return float(np.linalg.norm(track[-1] - track[0]))

    def distance(self, a: str, b: str) -> float:
        """How far apart (m) the middles of two bodies are at the end."""
        last = self.trace.position[-1]
        return float(np.linalg.norm(last[self._bodies[a]] - last[self._bodies[b]]))

    def contact(self, a: str, b: str) -> bool:
        """Whether the two touched at any time."""
        return any({c.first, c.second} == {a, b} for c in self.trace.contacts)

    def fastest(self, bodies: tuple[str, ...]) -> str:
        """The body with the largest speed; of equals, the first."""
        return max(bodies, key=lambda b: self.call("speed", (b,)))

    def slowest(self, bodies: tuple[str, ...]) -> str:
        """The body with the smallest speed; of equals, the first."""
        return min(bodies, key=lambda b: self.call("speed", (b,)))

    def frame(self, camera: str, time: float) -> tuple[str, float]:
        """Which picture is meant: its camera and time (s)."""
        return camera, time


_MEASURES: dict[str, Callable[..., Any]] = {
    name: getattr(Measured, name) for name, function in FUNCTIONS.items() if function.measured
}
