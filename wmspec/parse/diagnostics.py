"""What is wrong with a spec, where, and what would be right."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

from wmspec.errors import WmsError
from wmspec.parse.source import Span

Severity = Literal["error", "warning"]

#: Every code with its meaning. The hundreds are the stages: text, names, units, design, questions, scene.
CODES: dict[str, str] = {
    "WMS101": "unexpected text",
    "WMS102": "unreadable character",
    "WMS103": "unknown unit",
    "WMS105": "nested too deeply",
    "WMS201": "unknown name",
    "WMS202": "name declared twice",
    "WMS203": "unknown property",
    "WMS204": "unknown verb or function",
    "WMS205": "wrong arguments",
    "WMS206": "missing property",
    "WMS207": "library not found",
    "WMS208": "libraries use each other in a circle",
    "WMS209": "values depend on each other in a circle",
    "WMS210": "file that cannot be used",
    "WMS301": "wrong unit",
    "WMS302": "wrong kind of value",
    "WMS303": "measured value where none can be",
    "WMS304": "impossible value",
    "WMS401": "domain without values",
    "WMS402": "require leaves nothing",
    "WMS403": "factor without effect",
    "WMS404": "require too costly",
    "WMS405": "misplaced statement",
    "WMS406": "require without effect",
    "WMS407": "condition on what is drawn",
    "WMS408": "impossible design",
    "WMS409": "factor in words alone",
    "WMS501": "question without answer",
    "WMS502": "options and answer do not fit",
    "WMS503": "counterfactual without effect",
    "WMS504": "nothing is observed",
    "WMS505": "counterfactual of several changes",
    "WMS506": "answer that never varies",
    "WMS507": "options that coincide",
    "WMS601": "objects inside one another",
    "WMS602": "camera that misses the matter",
    "WMS603": "camera that looks another way",
}


@dataclass(frozen=True)
class Note:
    """Another place that has to do with the mistake."""

    message: str
    span: Span


@dataclass(frozen=True)
class Diagnostic:
    """One mistake: its code, one sentence, the place, other places involved and a remedy."""

    code: str
    message: str
    span: Span
    help: str = ""
    notes: tuple[Note, ...] = ()
    severity: Severity = "error"

    def render(self) -> str:
        """The diagnostic as text: a headline, the source line with a caret, notes and the remedy."""
        lines = [f"{self.severity}[{self.code}]: {self.message}", *_excerpt(self.span)]
        for note in self.notes:
            lines += [f"note: {note.message}", *_excerpt(note.span)]
        if self.help:
            lines.append(f"help: {self.help}")
        return "\n".join(lines)

    def record(self) -> dict[str, object]:
        """The diagnostic as plain values, for JSON."""
        return {
            "code": self.code,
            "severity": self.severity,
            "message": self.message,
            **_place(self.span),
            "help": self.help,
            "notes": [{"message": n.message, **_place(n.span)} for n in self.notes],
        }


def _place(span: Span) -> dict[str, object]:
    line, column = span.source.position(span.end)
    return {"file": span.source.name, "line": span.line, "column": span.column, "endLine": line, "endColumn": column}


def _excerpt(span: Span) -> Iterator[str]:
    text = span.source.line(span.line)
    start = span.column - 1
    window = max(0, start - 100)
    shown = text[window : window + 160].replace("\t", " ")
    carets = max(1, min(span.end - span.start, len(text) - start, 160))
    gutter = " " * len(str(span.line))
    yield f"{gutter}--> {span}"
    yield f"{gutter} |"
    yield f"{span.line} | {shown}"
    yield f"{gutter} | {' ' * (start - window)}{'^' * carets}"


class SpecError(WmsError):
    """A spec has mistakes: all of them."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n\n".join(d.render() for d in self.diagnostics))


class Report:
    """Collects the diagnostics of one run over a spec, each once, and gives them in the order of the text."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str, int, str], Diagnostic] = {}

    def add(
        self,
        code: str,
        message: str,
        span: Span,
        help: str = "",
        notes: tuple[Note, ...] = (),
        severity: Severity = "error",
    ) -> None:
        """Record a mistake."""
        self.include([Diagnostic(code, message, span, help, notes, severity)])

    def include(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Record mistakes that another report has."""
        for d in diagnostics:
            self._found.setdefault((d.code, d.span.source.name, d.span.start, d.message), d)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All that was recorded, by file and place."""
        return tuple(sorted(self._found.values(), key=lambda d: (d.span.source.name, d.span.start, d.code)))

    @property
    def failed(self) -> bool:
        """Whether anything recorded is an error."""
        return any(d.severity == "error" for d in self._found.values())

    def stop_if_failed(self) -> None:
        """Raise `SpecError` with everything recorded if anything is an error."""
        if self.failed:
            raise SpecError(self.diagnostics)
