"""Checks texts of questions: their values in braces, and how each is worded."""

from __future__ import annotations

import re

from wmspec.core.places import Span
from wmspec.lang.check.expressions.domains import labels, read_domain
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import ZERO, Failed
from wmspec.lang.check.ir import ir
from wmspec.lang.check.library.modules import Modules
from wmspec.lang.check.statements.question_kinds import ANSWER
from wmspec.lang.check.types.types import LABEL, OBJECT, TEXT, List, Quantity, Type, Vector, Word, article
from wmspec.lang.check.types.units import NUMBER
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.parser import parse_expression

_HOLE = re.compile(r"(?<!\\)\{([^{}]*)\}")
_BRACE = re.compile(r"(?<!\\)[{}]")
#: Values in texts as other languages write them, and what is wrong with them.
_FOREIGN_HOLES = (
    (re.compile(r"\$\{([^{}]*)\}"), "a value in a text has no `$` before it"),
    (re.compile(r"(?<!\\)\{\{([^{}]*)\}\}"), "a value in a text stands in single braces"),
    (re.compile(r"%\((\w+)\)[a-z]"), "a value in a text stands in braces"),
    (re.compile(r"(?<!\\)\{([^{}:]*):[^{}:]*\}"), "values in texts have no format"),
)


class QuestionTexts:
    """Checks texts with values in braces; an error is reported and raises `Failed`."""

    def __init__(self, check: Expressions, modules: Modules) -> None:
        self.check = check
        self.modules = modules
        self.report = check.report

    def pieces(self, text: s.Pieces) -> tuple[str | ir.Interpolation, ...]:
        """Return the whole text of a question, with its pieces joined."""
        parts: list[str | ir.Interpolation] = []
        for part in (part for piece in text.pieces for part in (" ", *self.text(piece))):
            if isinstance(part, str) and parts and isinstance(parts[-1], str):
                parts[-1] += part
            elif parts or part != " ":
                parts.append(part)
        return tuple(parts)

    def text(self, text: s.Text) -> tuple[str | ir.Interpolation, ...]:
        """Split a text at its `{expression}`s and check these."""
        parts: list[str | ir.Interpolation] = []
        raw = text.span.text
        end = 1
        self._check_foreign_holes(text, raw)
        for brace in _BRACE.finditer(_HOLE.sub(lambda hole: " " * len(hole[0]), raw)):
            at = text.span.start + brace.start()
            remedy = "write `{EXPRESSION}` for a value, or `\\{` and `\\}` for braces"
            what = "closed" if brace[0] == "{" else "opened"
            self.check.fail("WMS101", f"this brace is never {what}", Span(text.span.source, at, at + 1), remedy)
        for hole in _HOLE.finditer(raw):
            parts.append(_unescape(raw[end : hole.start()]))
            end = hole.end()
            span = Span(text.span.source, text.span.start + hole.start(1), text.span.start + hole.end(1))
            expr = parse_expression(span, self.report)
            if expr is None:
                raise Failed
            typed = self.check.infer(self.modules.plain(expr))
            sort = str(TEXT) if self._named(typed.expr) else spoken_type(typed.type)
            if sort is None:
                self.check.fail("WMS302", f"{article(str(typed.type))} has no wording in a text", span)
            parts.append(ir.Interpolation(value=typed.expr, sort=sort))
        parts.append(_unescape(raw[end:-1]))
        return tuple(part for part in parts if part != "")

    def _check_foreign_holes(self, text: s.Text, raw: str) -> None:
        """Report values in a text that are written as in another language."""
        for pattern, message in _FOREIGN_HOLES:
            if (found := pattern.search(raw)) is not None:
                span = Span(text.span.source, text.span.start + found.start(), text.span.start + found.end())
                self.check.fail("WMS101", message, span, f"write `{{{found[1].strip()}}}`")

    def templates(self, clauses: dict[str, list[s.Clause]]) -> tuple[ir.TextTemplate, ...]:
        """Return the texts with inserted values among options and answers."""
        written = [clause.value for kind in ("options", ANSWER) for clause in clauses.get(kind, [])]
        holes = {text.value: text for text in s.nodes(tuple(written), s.Text) if _BRACE.search(text.span.text)}
        return tuple(ir.TextTemplate(text=value, parts=self.text(text)) for value, text in holes.items())

    def _named(self, expr: ir.Expr) -> bool:
        """Whether an expression is a factor or nuisance with labelled values."""
        factor = self.check.scope.names.get(expr.name) if isinstance(expr, ir.Ref) else None
        return isinstance(factor, s.Factor) and labels(read_domain(self.check, factor.domain)) is not None


def spoken_type(of: Type) -> str | None:
    """Return the name of a type whose values have a wording, or None."""
    if of == Quantity(ZERO):
        return str(Quantity(NUMBER))
    if isinstance(of, List):
        return str(of) if of.item is not None and spoken_type(of.item) else None
    return str(of) if isinstance(of, Word | Quantity | Vector) or of in (OBJECT, TEXT, LABEL) else None


def _unescape(text: str) -> str:
    return re.sub(r"\\(.)", lambda m: {"n": "\n", "t": "\t"}.get(m[1], m[1]), text)
