"""One name for another, everywhere that it is meant: in the document, in libraries, and in the specs that use these."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import Span
from wmspec.editor.document import Document
from wmspec.editor.names import Names, Occurrence
from wmspec.lang.check.expressions.scope import BUILTIN, RESERVED
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.files import library_folder
from wmspec.lang.parse.tables import tables


def meant(documents: Iterable[Document], occurrence: Occurrence) -> dict[Path, tuple[Span, ...]]:
    """Everywhere in the documents that the same declaration is meant."""
    spans_of = {d.path: Names(d).of(occurrence.declared) for d in documents}
    return {path: spans for path, spans in spans_of.items() if spans}


def renamed(documents: Iterable[Document], occurrence: Occurrence, name: str) -> dict[Path, tuple[Span, ...]]:
    """What to replace by the new name. Raises WmsError where that cannot be, or would change what something means."""
    old, declared = occurrence.span.text, occurrence.declared
    if isinstance(declared.node, s.File):
        raise WmsError("a library is called as its file is; rename that")
    if declared.path.parent == library_folder().resolve():
        raise WmsError(f"`{old}` is declared in a library that comes with wmspec")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        raise WmsError(f"`{name}` is no name: it has letters, digits and `_`, and begins with no digit")
    if name in RESERVED or name in tables().keywords:
        raise WmsError(f"`{name}` is a word of the language; choose another name")
    if old in BUILTIN:
        raise WmsError(f"`{old}` is a word of the language too; rename by hand where the thing is meant")
    places = meant(documents, occurrence)
    for document in documents:
        if document.path in places and name in Names(document).visible(places[document.path][0].start):
            raise WmsError(f"there is a `{name}` in {document.source.name} already")
    return places
