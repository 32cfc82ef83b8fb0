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
from wmspec.editor.protocol import path_of, uri_of
from wmspec.editor.rename import occurrences_of, rename_places
from wmspec.editor.semantic_tokens import MODIFIERS, TYPES, semantic_tokens
from wmspec.editor.server import Server, read
from wmspec.editor.signatures import signature_at
from wmspec.editor.trial import try_spec
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
    only = params.context.only
    source_actions = only is None or any(lsp.CodeActionKind.Source.startswith(kind) for kind in only)
    return [*(fix for fix in made if fix is not None), *([trial_action(uri)] if source_actions else [])]


def signature_help(ls: Server, params: lsp.SignatureHelpParams) -> lsp.SignatureHelp | None:
    """Return the signature of the call at a position."""
    document, positions = ls.document(params.text_document.uri)
    found = signature_at(document, positions.offset(params.position))
    if found is None:
        return None
    parameters = [lsp.ParameterInformation(p.label, p.meaning or None) for p in found.parameters]
    shown = lsp.SignatureInformation(found.label, found.meaning, parameters, active_parameter=found.active)
    return lsp.SignatureHelp([shown], 0, found.active)


def tokens(ls: Server, params: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
    """Return the type of every word, relative to the one before it."""
    document, positions = ls.document(params.text_document.uri)
    data: list[int] = []
    line = character = 0
    for token in semantic_tokens(document):
        where = positions.between(token.start, token.end)
        down = where.start.line - line
        across = where.start.character - (0 if down else character)
        data += [down, across, where.end.character - where.start.character, token.type, token.modifiers]
        line, character = where.start.line, where.start.character
    return lsp.SemanticTokens(data)


def trial_action(uri: str) -> lsp.CodeAction:
    """Return the action that tries the spec of a document."""
    title = "Try four instances of each task through all gates"
    return lsp.CodeAction(title, lsp.CodeActionKind.Source, command=lsp.Command(title, "wmspec.try", arguments=[uri]))


async def trial(ls: Server, uri: str) -> str:
    """Try the saved spec of a document; show and return what `wmspec check --try` prints."""
    found = await asyncio.to_thread(try_spec, path_of(uri))
    ls.window_show_message(lsp.ShowMessageParams(lsp.MessageType.Info, found))
    return found


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
    (lsp.TEXT_DOCUMENT_COMPLETION, completion, lsp.CompletionOptions(trigger_characters=[".", ":", " ", "(", "{"])),
    (lsp.TEXT_DOCUMENT_HOVER, hovered, None),
    (lsp.TEXT_DOCUMENT_SIGNATURE_HELP, signature_help, lsp.SignatureHelpOptions(["(", ","])),
    (lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, tokens, lsp.SemanticTokensLegend(TYPES, MODIFIERS)),
    (lsp.TEXT_DOCUMENT_DEFINITION, definition, None),
    (lsp.TEXT_DOCUMENT_REFERENCES, references, None),
    (lsp.TEXT_DOCUMENT_PREPARE_RENAME, prepare_rename, None),
    (lsp.TEXT_DOCUMENT_RENAME, rename, lsp.RenameOptions(prepare_provider=True)),
    (lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL, symbols, None),
    (lsp.TEXT_DOCUMENT_FORMATTING, formatting, None),
    (
        lsp.TEXT_DOCUMENT_CODE_ACTION,
        fixes,
        lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix, lsp.CodeActionKind.Source]),
    ),
)
COMMANDS = (("wmspec.preview", preview), ("wmspec.try", trial))
