"""Conversion to the types of the language server protocol: positions, diagnostics, fixes, completions, symbols."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from lsprotocol import types as lsp
from pygls.uris import from_fs_path, to_fs_path
from pygls.workspace import PositionCodec, TextDocument
from pygls.workspace.position_codec import ServerTextPosition

from wmspec.core.diagnostics import Diagnostic, Remedy
from wmspec.core.node import Node
from wmspec.core.places import FilePlace, Place, Span
from wmspec.editor.complete import CompletionItem, ItemKind
from wmspec.editor.document import Document, children
from wmspec.lang.parse import codes
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.codes import CODES
from wmspec.lang.parse.files import resolve_display_path

#: The folder with the page of each code, as shown by `wmspec explain`.
PAGES = Path(codes.__file__).parent

_SORTS: dict[ItemKind, lsp.CompletionItemKind] = {
    "property": lsp.CompletionItemKind.Property,
    "argument": lsp.CompletionItemKind.Field,
    "unit": lsp.CompletionItemKind.Unit,
    "name": lsp.CompletionItemKind.Variable,
    "function": lsp.CompletionItemKind.Function,
    "verb": lsp.CompletionItemKind.Method,
    "word": lsp.CompletionItemKind.EnumMember,
    "keyword": lsp.CompletionItemKind.Keyword,
    "library": lsp.CompletionItemKind.Module,
    "part": lsp.CompletionItemKind.Property,
}
_SYMBOLS: dict[type, lsp.SymbolKind] = {
    s.Task: lsp.SymbolKind.Class,
    s.Variant: lsp.SymbolKind.Class,
    s.Factor: lsp.SymbolKind.Enum,
    s.Let: lsp.SymbolKind.Constant,
    s.Parameter: lsp.SymbolKind.Constant,
    s.Template: lsp.SymbolKind.Interface,
    s.Block: lsp.SymbolKind.Object,
    s.Part: lsp.SymbolKind.Field,
    s.Action: lsp.SymbolKind.Event,
    s.Question: lsp.SymbolKind.Function,
    s.Counterfactual: lsp.SymbolKind.Variable,
}


class Positions:
    """Converts between offsets in a text and positions in the units that the client chose."""

    def __init__(self, text: TextDocument) -> None:
        self._text = text

    def offset(self, position: lsp.Position) -> int:
        """Return the offset of a position."""
        return min(self._text.offset_at_position(position), len(self._text.source))

    def range(self, span: Span) -> lsp.Range:
        """Return the range of a span of this text."""
        return self.between(span.start, span.end)

    def between(self, start: int, end: int) -> lsp.Range:
        """Return the range between two offsets."""
        return lsp.Range(self._position(start), self._position(end))

    def _position(self, offset: int) -> lsp.Position:
        before = self._text.source[:offset]
        there = ServerTextPosition(before.count("\n"), offset - (before.rfind("\n") + 1))
        return self._text.position_to_client_units(there)


def positions_in(document: Document, codec: PositionCodec) -> Positions:
    """Return the positions in a document, open or not."""
    return Positions(TextDocument(uri_of(document.path), document.text, position_codec=codec))


def path_of(uri: str) -> Path:
    """Return the path of a document; for an unsaved one, its name in the current folder."""
    path = to_fs_path(uri) if uri.startswith("file:") else None
    return Path(path or uri.rpartition(":")[2] or "untitled").resolve()


def uri_of(path: Path) -> str:
    """Return the URI of a file."""
    return from_fs_path(str(path)) or path.as_uri()


def lsp_diagnostic(d: Diagnostic, text: TextDocument) -> lsp.Diagnostic:
    """Return the diagnostic for editors; one of another file is at the start of the text and names its place."""
    codec = text.position_codec
    here = isinstance(d.place, Span) and resolve_display_path(d.place.source.name).resolve() == path_of(text.uri)
    message = d.message if here or d.place is None else f"{d.place}: {d.message}"
    related = [r for note in d.notes if (r := _related(note.message, note.place, codec)) is not None]
    if not here and (where := _related(d.message, d.place, codec)) is not None:
        related.insert(0, where)
    return lsp.Diagnostic(
        range=Positions(text).range(d.place) if here and isinstance(d.place, Span) else Positions(text).between(0, 0),
        message=f"{message}\nhelp: {d.help}" if d.help else message,
        severity=lsp.DiagnosticSeverity.Error if d.severity == "error" else lsp.DiagnosticSeverity.Warning,
        source="wmspec",
        code=d.code or None,
        code_description=lsp.CodeDescription(uri_of(PAGES / f"{d.code}.md")) if d.code in CODES else None,
        related_information=related or None,
    )


def _related(message: str, place: Place | None, codec: PositionCodec) -> lsp.DiagnosticRelatedInformation | None:
    match place:
        case Span(source=source):
            document = Document(resolve_display_path(source.name).resolve(), source.text)
            location = lsp.Location(uri_of(document.path), positions_in(document, codec).range(place))
        case FilePlace(path, line):
            start = lsp.Position((line or 1) - 1, 0)
            location = lsp.Location(uri_of(Path(path).resolve()), lsp.Range(start, start))
        case _:
            return None
    return lsp.DiagnosticRelatedInformation(location, message)


def quick_fix(d: Diagnostic, uri: str, positions: Positions, shown: Iterable[lsp.Diagnostic]) -> lsp.CodeAction | None:
    """Return the remedy of a diagnostic as an edit, if it has one."""
    if not isinstance(d.help, Remedy) or not isinstance(d.place, Span) or d.place.text.count(d.help.wrong) == 0:
        return None
    start = d.place.start + d.place.text.rindex(d.help.wrong)
    where = positions.between(start, start + len(d.help.wrong))
    return lsp.CodeAction(
        title=f"write `{d.help.right}`",
        kind=lsp.CodeActionKind.QuickFix,
        is_preferred=True,
        diagnostics=[each for each in shown if each.code == d.code and each.range == positions.range(d.place)],
        edit=lsp.WorkspaceEdit(changes={uri: [lsp.TextEdit(where, d.help.right)]}),
    )


# ---------------------------------------------------------------- completions and symbols


def lsp_completion(number: int, offer: CompletionItem, where: lsp.Range) -> lsp.CompletionItem:
    """Return a suggestion that replaces a range; `number` is its rank."""
    return lsp.CompletionItem(
        label=offer.word,
        kind=_SORTS[offer.sort],
        detail=offer.detail or None,
        documentation=offer.meaning or None,
        sort_text=f"{number:04}",
        text_edit=lsp.TextEdit(where, offer.written or offer.word),
        filter_text=offer.word,
    )


def symbols(node: Node, positions: Positions) -> Iterator[lsp.DocumentSymbol]:
    """Yield the declarations of a file, a task or a block, as a tree."""
    for _, child in children(node):
        kind = _SYMBOLS.get(type(child))
        if kind is None:
            continue
        named = getattr(child, "name", None)
        span: Span = named.span if named is not None else child.span  # type: ignore[attr-defined]
        name = named.id if named is not None else child.text.value  # type: ignore[attr-defined]
        yield lsp.DocumentSymbol(
            name=name or "?",
            kind=kind,
            range=positions.range(child.span),  # type: ignore[attr-defined]
            selection_range=positions.range(span),
            detail=getattr(child, "kind", ""),
            children=list(symbols(child, positions)),
        )
