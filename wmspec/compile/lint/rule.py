"""What a rule is: a code, how bad a breach of it is, and the function that finds the breaches."""

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
    """What breaks a rule, where, and a remedy. Breaches of a rule with the same `about` are one."""

    message: str
    place: Place
    help: str = ""
    notes: tuple[Note, ...] = ()
    about: Hashable = None


@dataclass(frozen=True)
class Rule(Generic[T]):
    """A rule on a task, a design, a scene and so on (`T`): its code is one of `wmspec.lang.parse.codes`."""

    code: str
    severity: Severity
    breaches: Callable[[T], Iterable[Breach]]


def rule(code: str, severity: Severity = "warning") -> Callable[[Callable[[T], Iterable[Breach]]], Rule[T]]:
    """Makes a rule of a function that finds its breaches."""
    return lambda breaches: Rule(code, severity, breaches)


@dataclass
class Linter:
    """Holds subjects to rules. What is so in many instances is reported of the first."""

    report: Report = field(default_factory=Report)
    _reported: set[Hashable] = field(default_factory=set)

    def check(self, subject: T, rules: Iterable[Rule[T]]) -> None:
        """Report the breaches of the rules by a task, a design, a scene or the like."""
        for r in rules:
            for b in r.breaches(subject):
                if self._fresh((r.code, b.about or b.place)):
                    self.report.add(r.code, b.message, b.place, b.help, b.notes, r.severity)

    @contextmanager
    def going_on(self) -> Iterator[None]:
        """Report what keeps something from being built, at each place once, and go on after the block."""
        try:
            yield
        except WmsError as error:
            self.report.include(d for d in _coded(error) if self._fresh(d.place))

    def _fresh(self, about: Hashable) -> bool:
        fresh = about not in self._reported
        self._reported.add(about)
        return fresh


def _coded(error: WmsError) -> Iterator[Diagnostic]:
    """What an error says; what has no code of its own is an impossible value."""
    yield from (d if d.code else replace(d, code=ImpossibleValue.code) for d in error.diagnostics)
