"""Rename a name in a document, in libraries, and in the specs that use these."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import Span
from wmspec.editor.document import Document
from wmspec.editor.names import Names, Occurrence
from wmspec.lang.check.expressions.scope import BUILTIN, RESERVED
from wmspec.lang.check.statements.task import words_in
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.files import library_folder
from wmspec.lang.parse.tables import tables


def occurrences_of(documents: Iterable[Document], occurrence: Occurrence) -> dict[Path, tuple[Span, ...]]:
    """Return all occurrences of the same declaration in the documents."""
    spans_of = {d.path: Names(d).of(occurrence.declared) for d in documents}
    return {path: spans for path, spans in spans_of.items() if spans}


def rename_places(documents: Iterable[Document], occurrence: Occurrence, name: str) -> dict[Path, tuple[Span, ...]]:
    """Return the spans to replace by the new name. Raises WmsError if it is impossible or would change a meaning."""
    old, declared = occurrence.span.text, occurrence.declared
    if isinstance(declared.node, s.File):
        raise WmsError("a library has the name of its file; rename the file")
    if declared.path.parent == library_folder().resolve():
        raise WmsError(f"`{old}` is declared in a library of wmspec")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        raise WmsError(f"`{name}` is not a name: names are letters, digits and `_`, and do not begin with a digit")
    if name in RESERVED or name in tables().keywords:
        raise WmsError(f"`{name}` is a word of the language; choose another name")
    documents = list(documents)
    places = occurrences_of(documents, occurrence)
    if old in BUILTIN:
        places = _without_words(documents, places, old)
    for document in documents:
        if document.path in places and name in Names(document).visible(places[document.path][0].start):
            raise WmsError(f"`{name}` already exists in {document.source.name}")
    return places


def _without_words(
    documents: Iterable[Document], places: dict[Path, tuple[Span, ...]], old: str
) -> dict[Path, tuple[Span, ...]]:
    """Return the places where a name that is also a word of the language is the name."""
    kept: dict[Path, tuple[Span, ...]] = {}
    for document in (document for document in documents if document.path in places):
        words = words_in(document.program)
        if words is None:
            what = f"`{old}` is also a word of the language, and {document.source.name} has mistakes"
            raise WmsError(what, help="correct them first")
        spans = (span for span in places[document.path] if (span.source.name, span.start) not in words)
        kept[document.path] = tuple(spans)
    return kept
