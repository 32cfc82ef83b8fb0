"""Line and column positions of a formatted spec, derived from the syntax tree."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable
from itertools import pairwise

from wmspec.core.places import Span
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.tables import tables

#: Spaces per level.
INDENT = 2

_TIGHT_BEFORE = {"COMMA", "COLON", "DOT", "RPAR", "RSQB", "LIST_UNIT"}
_TIGHT_AFTER = {"LPAR", "LSQB", "DOT"}

_Clause = s.Clause | s.Legibility | s.ModelText | s.Kinds | s.Counterfactual | s.EachOther
Part = s.Statement | s.Task | s.Variant | _Clause


def token_text(token: Token) -> str:
    """Return the text of a token with one space between number and unit and no trailing space in comments."""
    text = token.text
    match token.type:
        case "QUANTITY":
            number = len(text) - len(text.lstrip("0123456789."))
            if text[number : number + 1] in ("e", "E") and text[number + 1 :].lstrip("+-")[:1].isdigit():
                number = len(text) - len(text[number + 1 :].lstrip("+-").lstrip("0123456789"))
            return f"{text[:number]} {text[number:].strip()}"
        case "LIST_UNIT":
            return f" {text.strip()}"
        case "COMMENT":
            return text.rstrip()
    return text


class Layout:
    """Layout of tokens, each identified by its start offset.

    `breaks`: tokens that begin a line. `hangs`: extra indentation relative to the block. `opens`, `closes`: braces of
    multi-line blocks. `cells`: tokens that begin a column, with its kind.
    """

    def __init__(self, tokens: list[Token], items: Iterable[Part], width: int) -> None:
        self.breaks: set[int] = set()
        self.hangs: dict[int, int] = {}
        self.opens: set[int] = set()
        self.closes: set[int] = set()
        self.cells: dict[int, str] = {}
        self._wide: set[int] = set()
        self._headings: set[int] = set()
        self._tokens = tokens
        self._starts = [t.start for t in tokens]
        self._width = width
        self._level = 0
        self._parts(items)

    def gap(self, i: int) -> str:
        """Return the space before token `i` when it does not begin a line."""
        before, here = self._tokens[i - 1], self._tokens[i]
        if here.start in self._wide:
            return "  "
        if here.start in self._headings:
            return " "
        signs = before.type == "MINUS" and (
            i < 2 or self._tokens[i - 2].type not in tables().value_ends or before.start in self.cells
        )
        calls = here.type in ("LPAR", "LSQB") and before.type in ("NAME", "RPAR")
        return "" if here.type in _TIGHT_BEFORE or before.type in _TIGHT_AFTER or signs or calls else " "

    def begins_line(self, token: Token) -> bool:
        """Whether a token begins a line wherever the author put it."""
        return token.start in self.breaks or token.start in self.closes

    # ------------------------------------------------------------ finding tokens

    def _index(self, offset: int) -> int:
        return bisect_left(self._starts, offset)

    def _after(self, offset: int) -> int:
        """Return the offset of the next token that is no comment."""
        i = self._index(offset) + 1
        while self._tokens[i].type == "COMMENT":
            i += 1
        return self._starts[i]

    def _before(self, offset: int) -> int:
        """Return the offset of the last token before `offset` that is no comment."""
        i = self._index(offset) - 1
        while self._tokens[i].type == "COMMENT":
            i -= 1
        return self._starts[i]

    def _length(self, span: Span) -> int:
        """Return the length (characters) of a span's tokens on one line."""
        first, last = self._index(span.start), self._index(span.end)
        return sum(len(token_text(self._tokens[i])) + len(self.gap(i)) * (i > first) for i in range(first, last))

    # ------------------------------------------------------------ statements

    def _parts(self, parts: Iterable[Part]) -> None:
        for part in parts:
            self.breaks.add(part.span.start)
            self.cells[part.span.start] = type(part).__name__
            self._part(part)

    def _part(self, x: Part) -> None:
        match x:
            case s.Task():
                colon = self._after(x.name.span.start)
                if self._tokens[self._index(colon)].type == "COLON":
                    self._headings.add(colon)
                self._body(x.span, x.name.span.end, x.body)
            case s.Variant():
                self._body(x.span, x.name.span.end, x.body)
            case s.Question():
                clauses: list[_Clause] = [*x.clauses, *x.legibility, *x.model_texts, *x.kinds, *x.counterfactuals]
                self._pieces(x)
                self._body(x.span, x.text.span.end, sorted(clauses, key=lambda part: part.span.start))
            case s.Block() | s.Template():
                self._members(x)
            case s.Kinds():
                self._block(x.span, [(p.name.id, p.span) for p in x.kinds])
                self.cells.update((p.value.span.start, "value") for p in x.kinds)
            case s.Counterfactual():
                self._block(x.span, [(c.kind, c.span) for c in x.changes])
                self._changes(x.changes)
            case _:
                self._line(x)

    def _members(self, x: s.Block | s.Template) -> None:
        """Lay out an object, camera, …: its properties, then its parts, each on its own line."""
        if isinstance(x, s.Block) and x.model is not None:
            self._headings.add(self._before(x.model.span.start))
        after = x.parameters[-1].span.end if isinstance(x, s.Template) and x.parameters else x.span.start
        properties = [(p.name.id, p.span) for p in x.properties]
        self._block(x.span, properties, after, whole=not x.parts)
        self._level += 1
        for part in x.parts:
            self.breaks.add(part.span.start)
            self.cells[part.span.start] = "part"
            self.cells[part.name.span.start] = "name"
            self._block(part.span, [(p.name.id, p.span) for p in part.properties])
        self._level -= 1

    def _pieces(self, x: s.Question | s.ModelText) -> None:
        """Align the pieces of a text under the first."""
        first, *others = x.text.pieces
        before, here = self._index(x.span.start), self._index(first.span.start)
        beside = self._tokens[here - 1].end_line == self._tokens[here].line
        hang = sum(len(t.text) + 1 for t in self._tokens[before:here]) if beside else 2 * INDENT
        for piece in others:
            self.breaks.add(piece.span.start)
            self.hangs |= dict.fromkeys(self._starts[here + 1 : self._index(piece.span.end)], hang)

    def _line(self, x: Part) -> None:
        match x:
            case s.Factor() | s.Let() | s.Parameter():
                self.cells[x.name.span.start] = "name"
                self.cells[self._equals(x)] = "="
                if isinstance(x, s.Factor) and x.about is not None:
                    self.cells[self._before(x.about.span.start)] = "about"
            case s.Action():
                self._action(x)
            case s.Design() if x.baseline:
                self._block(x.span, [(p.name.id, p.span) for p in x.baseline])
            case s.Observe():
                self.cells[self._after(x.camera.span.start)] = "at"
            case s.Clause(kind="hide"):
                self.cells[x.value.span.start] = "value"
            case s.ModelText():
                self._pieces(x)
            case s.Setting() | s.Clause() | s.Legibility() | s.Tolerance():
                self.cells[self._after(x.span.start)] = "value"

    def _changes(self, changes: Iterable[s.Change]) -> None:
        for change in changes:
            if change.kind in ("action", "state", "level") and change.value is not None:
                self.cells[change.target.span.start] = "target"
                self.cells[change.value.span.start] = "value"

    def _action(self, action: s.Action) -> None:
        self.cells[self._equals(action)] = "="
        if isinstance(action.call, s.Call):
            for i, argument in enumerate(action.call.arguments[1:]):
                self.cells[argument.span.start] = f"argument {argument.name.id if argument.name else i}"
        for timing in action.timings:
            self.cells[timing.span.start] = timing.kind

    def _equals(self, x: s.Factor | s.Let | s.Parameter | s.Action) -> int:
        """Return the offset of the `=` or `in` of a declaration, after its name and the number of a set."""
        counted = x.count if isinstance(x, s.Factor | s.Action) else None
        return self._after(x.name.span.start if counted is None else self._after(self._before(counted.span.end)))

    # ------------------------------------------------------------ blocks

    def _body(self, span: Span, after: int, parts: Iterable[Part]) -> None:
        """Lay out a block in which every statement has its own line."""
        brace, end = self._braces(span, after)
        if end - brace > 1:
            self._open(brace, end)
        self._level += 1
        self._parts(parts)
        self._level -= 1

    def _braces(self, span: Span, after: int) -> tuple[int, int]:
        first, last = self._index(after), self._index(span.end) - 1
        return next(i for i in range(first, last) if self._tokens[i].type == "LBRACE"), last

    def _open(self, brace: int, end: int) -> None:
        self.opens.add(self._starts[brace])
        self.closes.add(self._starts[end])

    def _block(self, span: Span, parts: list[tuple[str, Span]], after: int = 0, whole: bool = True) -> None:
        """Lay out a block of properties: on one line if written so and short enough, else in the author's rows.

        Its brace comes after offset `after`. If `whole` is false, the block is always multi-line.
        """
        brace, end = self._braces(span, after or span.start)
        for sort, part in parts[1:]:
            self.cells[part.start] = sort
            self._wide.add(part.start)
        inside = self._tokens[self._index(span.start) : end + 1]
        one_line = all(a.end_line == b.line for a, b in pairwise(inside)) and self._fits(span, self._level)
        if end - brace == 1 or (one_line and whole):
            self.cells[self._starts[brace]] = "{"
            return
        self._open(brace, end)
        rows = self._rows(parts)
        fitting = all(self._fits(row[0][1].to(row[-1][1]), self._level + 1) for row in rows)
        for row in rows:
            for sort, part in row[:1] if fitting else row:
                self.breaks.add(part.start)
                self.cells[part.start] = sort

    def _fits(self, span: Span, level: int) -> bool:
        return INDENT * level + self._length(span) <= self._width

    def _rows(self, parts: list[tuple[str, Span]]) -> list[list[tuple[str, Span]]]:
        """Return the properties grouped by the author's lines."""
        rows: list[list[tuple[str, Span]]] = []
        for part in parts:
            i = self._index(part[1].start)
            if rows and self._tokens[i - 1].end_line == self._tokens[i].line:
                rows[-1].append(part)
            else:
                rows.append([part])
        return rows
