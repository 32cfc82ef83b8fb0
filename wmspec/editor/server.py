"""The language server: the open documents, what is known of them, and when they are checked.

Offsets here are characters of the text, positions those of the protocol. What takes long, building scenes and drawing,
is done outside of the loop that answers.
"""

from __future__ import annotations

import asyncio
import gc
import logging
import tempfile
from functools import cached_property, partial
from pathlib import Path

from lsprotocol import types as lsp
from pygls.lsp.server import LanguageServer
from pygls.workspace import TextDocument

from wmspec import __version__
from wmspec.api.loading import TextCheck
from wmspec.core.diagnostics import Diagnostic, WmsError
from wmspec.editor.document import Document
from wmspec.editor.protocol import Positions, path_of, positions_in, shown
from wmspec.runtime.workers.pool import Helper

#: How long after the last key a text is checked (s), and how long a picture may take.
PAUSE, PATIENCE = 0.12, 120.0
#: So many specs of a folder are looked through for a name.
MOST_FILES = 500


class Server(LanguageServer):
    """Answers for the documents that are open; what was found out about a version of one is kept until the next."""

    def __init__(self) -> None:
        super().__init__("wmspec", __version__)
        self._documents: dict[str, tuple[int | None, Document]] = {}
        self._checks: dict[str, asyncio.Task[None]] = {}
        self.told: dict[str, tuple[Diagnostic, ...]] = {}

    def document(self, uri: str) -> tuple[Document, Positions]:
        """An open document as it is now."""
        text = self.workspace.get_text_document(uri)
        kept = self._documents.get(uri)
        if kept is None or kept[0] != text.version or kept[1].text != text.source:
            kept = (text.version, Document(path_of(uri), text.source))
            self._documents[uri] = kept
        return kept[1], Positions(text)

    def around(self, document: Document, declared: Path) -> list[Document]:
        """The documents in which a name of this one, or of the library that declares it, may be meant."""
        opened = {path_of(uri): doc.source for uri, doc in self.workspace.text_documents.items()}
        folders = {document.path.parent, declared.parent} | {path_of(uri) for uri in self.workspace.folders}
        nearby = [p for folder in sorted(folders) for p in sorted(folder.glob("**/*.wms"))[:MOST_FILES]]
        documents = {document.path: document}
        for path in dict.fromkeys([declared, *opened, *nearby]):
            if path not in documents and (path in opened or path.is_file()):
                documents[path] = Document(path, opened[path] if path in opened else read(path))
        return list(documents.values())

    # ------------------------------------------------------------ diagnostics

    def check_soon(self, uri: str) -> None:
        """Check a document once nobody types."""
        if (running := self._checks.get(uri)) is not None:
            running.cancel()
        self._checks[uri] = asyncio.get_running_loop().create_task(self._check(uri))

    async def _check(self, uri: str) -> None:
        """Tell what is wrong with the text at once, then what is wrong with its values."""
        await asyncio.sleep(PAUSE)
        text = self.workspace.get_text_document(uri)
        version, source, path = text.version, text.source, path_of(uri)
        try:
            check = await asyncio.to_thread(TextCheck, source, path)
            for tried in (False, True):
                diagnosis = await asyncio.to_thread(partial(check.diagnosis, tried=tried))
                if text.version != version:
                    return
                self._tell(text, diagnosis.diagnostics)
                if not diagnosis.passed:
                    return
        except WmsError as error:
            if text.version == version:
                self._tell(text, error.diagnostics)

    def _tell(self, text: TextDocument, diagnostics: tuple[Diagnostic, ...]) -> None:
        self.told[text.uri] = diagnostics
        told = [shown(d, text) for d in diagnostics]
        self.text_document_publish_diagnostics(
            lsp.PublishDiagnosticsParams(uri=text.uri, diagnostics=told, version=text.version)
        )

    def forget(self, uri: str) -> None:
        """A document was closed."""
        if (running := self._checks.pop(uri, None)) is not None:
            running.cancel()
        self._documents.pop(uri, None)
        self.told.pop(uri, None)
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri=uri, diagnostics=[]))

    def positions_in(self, document: Document) -> Positions:
        """The positions in a document that need not be open."""
        return positions_in(document, self.workspace.position_codec)

    @cached_property
    def drawer(self) -> Helper:
        """Who draws, in a process of its own."""
        return Helper(PATIENCE)

    @cached_property
    def pictures(self) -> tempfile.TemporaryDirectory[str]:
        """Where pictures are kept until the server ends."""
        return tempfile.TemporaryDirectory(prefix="wmspec-")

    def close(self) -> None:
        """End what was started, and remove what was drawn."""
        if "drawer" in self.__dict__:
            self.drawer.close()
        if "pictures" in self.__dict__:
            self.pictures.cleanup()


def read(path: Path) -> str:
    """The text of a file; nothing if it cannot be read."""
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return ""


def serve() -> None:
    """Answer on standard input and output until the client leaves."""
    from wmspec.editor.features import COMMANDS, FEATURES

    logging.getLogger("pygls").setLevel(logging.ERROR)
    # Libraries and syntax trees stay: looking for garbage in them every 700 objects takes a tenth of each check.
    gc.set_threshold(100_000, 20, 100)
    server = Server()
    for request, answer, options in FEATURES:
        server.feature(request, options)(answer)
    for command, answer_ in COMMANDS:
        server.command(command)(answer_)
    try:
        server.start_io()
    finally:
        server.close()
