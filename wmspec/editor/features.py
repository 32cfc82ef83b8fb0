"""Handlers of the language server, one function per request."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import Span
from wmspec.editor import protocol
from wmspec.editor.complete import complete
from wmspec.editor.document import Document
from wmspec.editor.hover import hover
from wmspec.editor.names import Names, Occurrence
from wmspec.editor.preview import Preview, instance_at
from wmspec.editor.protocol import uri_of
from wmspec.editor.rename import occurrences_of, rename_places
from wmspec.editor.server import Server, read
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.format import format_spec
from wmspec.runtime.workers.pool import JobFailure

T = TypeVar("T")


async def changed(ls: Server, params: lsp.DidOpenTextDocumentParams | lsp.DidChangeTextDocumentParams) -> None:
    """Check a text that was opened or edited."""
    ls.check_soon(params.text_document.uri)


async def saved(ls: Server, _: lsp.DidSaveTextDocumentParams) -> None:
    """Check all open texts: the saved file may be one of their libraries."""
    for uri in list(ls.workspace.text_documents):
        ls.check_soon(uri)


def closed(ls: Server, params: lsp.DidCloseTextDocumentParams) -> None:
    """Discard a closed text."""
    ls.forget(params.text_document.uri)


def completion(ls: Server, params: lsp.CompletionParams) -> lsp.CompletionList:
    """Return the suggestions at a position."""
    document, positions = ls.document(params.text_document.uri)
    offset = positions.offset(params.position)
    offers = complete(document, offset)
    where = positions.between(offers.start, offset)
    return lsp.CompletionList(
        False, [protocol.lsp_completion(i, offer, where) for i, offer in enumerate(offers.offers)]
    )


def hovered(ls: Server, params: lsp.HoverParams) -> lsp.Hover | None:
    """Return the documentation of the word at a position."""
    document, positions = ls.document(params.text_document.uri)
    about = hover(document, positions.offset(params.position))
    if about is None:
        return None
    text = lsp.MarkupContent(lsp.MarkupKind.Markdown, about.markdown)
    return lsp.Hover(text, positions.range(about.span))


def definition(ls: Server, params: lsp.DefinitionParams) -> lsp.Location | None:
    """Return the declaration of a name, also in a library."""
    document, name = _name(ls, params.text_document.uri, params.position)
    if name is None:
        return None
    there = document if name.declared.path == document.path else Document(name.declared.path, read(name.declared.path))
    start = name.declared.start
    end = start + (0 if isinstance(name.declared.node, s.File) else len(name.declared.node.name.span.text))
    return lsp.Location(uri_of(there.path), ls.positions_in(there).between(start, end))


def references(ls: Server, params: lsp.ReferenceParams) -> list[lsp.Location]:
    """Return all occurrences of a name."""
    document, name = _name(ls, params.text_document.uri, params.position)
    if name is None:
        return []
    documents = ls.around(document, name.declared.path)
    return [
        lsp.Location(uri_of(path), where)
        for path, ranges in _ranges(ls, documents, occurrences_of(documents, name))
        for where in ranges
    ]


def prepare_rename(ls: Server, params: lsp.PrepareRenameParams) -> lsp.Range | None:
    """Return the range of the name that would be renamed."""
    document, name = _name(ls, params.text_document.uri, params.position)
    return None if name is None else ls.positions_in(document).range(name.span)


def rename(ls: Server, params: lsp.RenameParams) -> lsp.WorkspaceEdit | None:
    """Return the edits that rename a name everywhere."""
    document, name = _name(ls, params.text_document.uri, params.position)
    if name is None:
        return None
    documents = ls.around(document, name.declared.path)
    places = _reported(lambda: rename_places(documents, name, params.new_name))
    changes = {
        uri_of(path): [lsp.TextEdit(where, params.new_name) for where in ranges]
        for path, ranges in _ranges(ls, documents, places)
    }
    return lsp.WorkspaceEdit(changes=changes)


def symbols(ls: Server, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
    """Return the declarations of a text."""
    document, positions = ls.document(params.text_document.uri)
    return list(protocol.symbols(document.file, positions))


def formatting(ls: Server, params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
    """Return the edits of `wmspec fmt`."""
    document, positions = ls.document(params.text_document.uri)
    try:
        formatted = format_spec(document.source)
    except WmsError:  # diagnostics are already published
        return []
    return [] if formatted == document.text else [lsp.TextEdit(positions.between(0, len(document.text)), formatted)]


def fixes(ls: Server, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    """Return the remedies that can be applied."""
    uri = params.text_document.uri
    _, positions = ls.document(uri)
    lines = range(params.range.start.line, params.range.end.line + 1)
    source = ls.workspace.get_text_document(uri).source
    current = (d for d in ls.published.get(uri, ()) if isinstance(d.place, Span) and d.place.source.text == source)
    near = (d for d in current if isinstance(d.place, Span) and d.place.line - 1 in lines)
    made = (protocol.quick_fix(d, uri, positions, params.context.diagnostics) for d in near)
    return [fix for fix in made if fix is not None]


async def preview(ls: Server, uri: str, position: lsp.Position | None = None) -> dict[str, object]:
    """Draw the instance at the cursor; return the picture's address and the instance."""
    document, positions = ls.document(uri)
    at = lsp.Position(position.line, position.character) if position is not None else lsp.Position(0, 0)
    offset = positions.offset(at)
    return await asyncio.to_thread(lambda: _reported(lambda: _drawn(ls, document, offset)))


def _reported(work: Callable[[], T]) -> T:
    """Return the result of `work`; a WmsError becomes the response to the request."""
    try:
        return work()
    except WmsError as error:
        raise JsonRpcException(message=str(error), code=lsp.LSPErrorCodes.RequestFailed.value) from None


def _drawn(ls: Server, document: Document, offset: int) -> dict[str, object]:
    which = instance_at(document, offset)
    png = ls.drawer.do(Preview.draw, which, document.text, document.path)
    if isinstance(png, JobFailure):
        raise WmsError(f"{which.task} cannot be drawn: {png.reason}")
    path = Path(ls.pictures.name, f"{which.task}-{which.index}.png")
    path.write_bytes(png)
    return {"uri": uri_of(path), "task": which.task, "instance": which.index, "factors": which.factors}


def _name(ls: Server, uri: str, position: lsp.Position) -> tuple[Document, Occurrence | None]:
    """Return the document and the name at the position of a request."""
    document, positions = ls.document(uri)
    return document, Names(document).at(positions.offset(position))


def _ranges(
    ls: Server, documents: list[Document], places: dict[Path, tuple[Span, ...]]
) -> Iterator[tuple[Path, list[lsp.Range]]]:
    for document in documents:
        if document.path in places:
            positions = ls.positions_in(document)
            yield document.path, [positions.range(span) for span in places[document.path]]


#: Each request with its handler and registration options.
FEATURES = (
    (lsp.TEXT_DOCUMENT_DID_OPEN, changed, None),
    (lsp.TEXT_DOCUMENT_DID_CHANGE, changed, None),
    (lsp.TEXT_DOCUMENT_DID_SAVE, saved, None),
    (lsp.TEXT_DOCUMENT_DID_CLOSE, closed, None),
    (lsp.TEXT_DOCUMENT_COMPLETION, completion, lsp.CompletionOptions(trigger_characters=[".", ":", " ", "("])),
    (lsp.TEXT_DOCUMENT_HOVER, hovered, None),
    (lsp.TEXT_DOCUMENT_DEFINITION, definition, None),
    (lsp.TEXT_DOCUMENT_REFERENCES, references, None),
    (lsp.TEXT_DOCUMENT_PREPARE_RENAME, prepare_rename, None),
    (lsp.TEXT_DOCUMENT_RENAME, rename, lsp.RenameOptions(prepare_provider=True)),
    (lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL, symbols, None),
    (lsp.TEXT_DOCUMENT_FORMATTING, formatting, None),
    (lsp.TEXT_DOCUMENT_CODE_ACTION, fixes, lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix])),
)
COMMANDS = (("wmspec.preview", preview),)
