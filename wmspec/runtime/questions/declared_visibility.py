"""Declared visibility: the pictures in which each object of a question must be visible."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Question
from wmspec.runtime.questions import visibility
from wmspec.runtime.questions.model import VisiblePart
from wmspec.runtime.questions.observed import Observed
from wmspec.runtime.questions.views import View

#: s: closer times are the same.
_MOMENT = 1e-6


@dataclass(frozen=True)
class DeclaredVisibility:
    """`times`: by object, the times (s) at which it must be visible. `unrestricted`: no object must be visible."""

    times: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    unrestricted: bool = False

    @property
    def required(self) -> frozenset[str]:
        """The objects that must be visible at some time because the question says so."""
        return frozenset(name for name, times in self.times.items() if times)

    def declares(self, name: str) -> bool:
        """Whether an object may be hidden in some picture."""
        return self.unrestricted or name in self.times

    def requires(self, names: Iterable[str], time: float) -> bool:
        """Whether one of these objects must be visible in a picture taken at `time` (s)."""
        if self.unrestricted:
            return False
        return any(
            name not in self.times or any(abs(time - own) < _MOMENT for own in self.times[name]) for name in names
        )


def declared_visibility(question: Question, values: Evaluator, views: Sequence[View]) -> DeclaredVisibility:
    """Return the declared visibility of an instance.

    Raises WmsError if an object must be visible at a time at which no picture is taken.
    """
    if any(each.objects is None for each in question.visibility):
        return DeclaredVisibility(unrestricted=True)
    times: dict[str, tuple[float, ...]] = {}
    for each in question.visibility:
        assert each.objects is not None
        named = evaluate(each.objects, values)
        own = () if each.times is None else tuple(evaluate(each.times, values))
        names = [n for n in (named if isinstance(named, tuple) else (named,)) if values.is_present(n)]
        for name in names:
            times[name] = own
            _require_pictures(name, own, views)
    return DeclaredVisibility(times)


def _require_pictures(name: str, times: Iterable[float], views: Sequence[View]) -> None:
    for time in times:
        if not any(abs(time - shown) < _MOMENT for _, shown in views):
            shown = ", ".join(f"{each:g} s" for each in sorted({each for _, each in views}))
            raise WmsError(f"`{name}` must be seen at {time:g} s, and the pictures are taken at {shown}")


def visible_parts(observed: Observed, names: Iterable[str]) -> tuple[VisiblePart, ...]:
    """Return the visible share of these objects in every shown picture."""
    present = {body.name for body in observed.scene.bodies}
    return tuple(
        VisiblePart(place, name, visibility.visible_part(observed, name, view))
        for place, view in enumerate(observed.views)
        for name in sorted(present.intersection(names))
    )
