"""Lint rules: a code, a severity, and a function that finds breaches."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Generic, TypeVar

from wmspec.core.diagnostics import Diagnostic, ImpossibleValue, Note, Report, Severity, WmsError
from wmspec.core.places import Place

T = TypeVar("T")


@dataclass(frozen=True)
class Breach:
    """A breach of a rule, with location and remedy. Breaches of a rule with the same `about` are reported once."""

    message: str
    place: Place
    help: str = ""
    notes: tuple[Note, ...] = ()
    about: Hashable = None


@dataclass(frozen=True)
class Rule(Generic[T]):
    """A rule on a task, a design, a scene and so on (`T`); codes are defined in `wmspec.lang.parse.codes`."""

    code: str
    severity: Severity
    breaches: Callable[[T], Iterable[Breach]]


def rule(code: str, severity: Severity = "warning") -> Callable[[Callable[[T], Iterable[Breach]]], Rule[T]]:
    """Return a decorator that makes a rule of a function that finds breaches."""
    return lambda breaches: Rule(code, severity, breaches)


@dataclass
class Linter:
    """Applies rules to subjects. A breach that occurs in many instances is reported for the first one."""

    report: Report = field(default_factory=Report)
    _reported: set[Hashable] = field(default_factory=set)

    def check(self, subject: T, rules: Iterable[Rule[T]]) -> None:
        """Report the breaches of the rules by a subject."""
        for r in rules:
            for b in r.breaches(subject):
                if self._fresh((r.code, b.about or b.place)):
                    self.report.add(r.code, b.message, b.place, b.help, b.notes, r.severity)

    @contextmanager
    def collecting(self) -> Iterator[None]:
        """Report errors raised in the block, once per location, and continue after it."""
        try:
            yield
        except WmsError as error:
            self.report.include(d for d in _with_code(error) if self._fresh(d.place))

    def _fresh(self, about: Hashable) -> bool:
        fresh = about not in self._reported
        self._reported.add(about)
        return fresh


def _with_code(error: WmsError) -> Iterator[Diagnostic]:
    """Yield the diagnostics of an error; those without a code become impossible values."""
    yield from (d if d.code else replace(d, code=ImpossibleValue.code) for d in error.diagnostics)
