"""The language server: open documents, their analysis, and when they are checked.

Offsets count characters of the text; positions are those of the protocol. Slow work, such as building scenes and
rendering, runs outside of the event loop.
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
from wmspec.core.safe_io import read_text
from wmspec.editor.document import Document
from wmspec.editor.protocol import Positions, lsp_diagnostic, path_of, positions_in
from wmspec.runtime.workers.pool import HelperProcess

#: The pause after the last key before a check, and the time limit of a picture, in seconds.
CHECK_DELAY, DRAW_TIMEOUT = 0.12, 120.0
#: The most specs of a folder that are searched for a name.
MAX_FILES = 500


class Server(LanguageServer):
    """Serves open documents; the analysis of a version is cached until the next."""

    def __init__(self) -> None:
        super().__init__("wmspec", __version__)
        self._documents: dict[str, tuple[int | None, Document]] = {}
        self._checks: dict[str, asyncio.Task[None]] = {}
        self.published: dict[str, tuple[Diagnostic, ...]] = {}

    def document(self, uri: str) -> tuple[Document, Positions]:
        """Return an open document in its current version."""
        text = self.workspace.get_text_document(uri)
        cached = self._documents.get(uri)
        if cached is None or cached[0] != text.version or cached[1].text != text.source:
            cached = (text.version, Document(path_of(uri), text.source))
            self._documents[uri] = cached
        return cached[1], Positions(text)

    def around(self, document: Document, declared: Path) -> list[Document]:
        """Return the documents that may contain a name of this one, or of the library that declares it."""
        opened = {path_of(uri): doc.source for uri, doc in self.workspace.text_documents.items()}
        folders = {document.path.parent, declared.parent} | {path_of(uri) for uri in self.workspace.folders}
        nearby = [p for folder in sorted(folders) for p in sorted(folder.glob("**/*.wms"))[:MAX_FILES]]
        documents = {document.path: document}
        for path in dict.fromkeys([declared, *opened, *nearby]):
            if path not in documents and (path in opened or path.is_file()):
                documents[path] = Document(path, opened[path] if path in opened else read(path))
        return list(documents.values())

    # ------------------------------------------------------------ diagnostics

    def check_soon(self, uri: str) -> None:
        """Check a document after a pause in typing."""
        if (running := self._checks.get(uri)) is not None:
            running.cancel()
        self._checks[uri] = asyncio.get_running_loop().create_task(self._check(uri))

    async def _check(self, uri: str) -> None:
        """Publish the mistakes of the text, then those of its scenes."""
        await asyncio.sleep(CHECK_DELAY)
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
        self.published[text.uri] = diagnostics
        published = [lsp_diagnostic(d, text) for d in diagnostics]
        self.text_document_publish_diagnostics(
            lsp.PublishDiagnosticsParams(uri=text.uri, diagnostics=published, version=text.version)
        )

    def forget(self, uri: str) -> None:
        """Discard a closed document."""
        if (running := self._checks.pop(uri, None)) is not None:
            running.cancel()
        self._documents.pop(uri, None)
        self.published.pop(uri, None)
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri=uri, diagnostics=[]))

    def positions_in(self, document: Document) -> Positions:
        """Return the positions in a document, open or not."""
        return positions_in(document, self.workspace.position_codec)

    @cached_property
    def drawer(self) -> HelperProcess:
        """The process that renders."""
        return HelperProcess(DRAW_TIMEOUT)

    @cached_property
    def pictures(self) -> tempfile.TemporaryDirectory[str]:
        """The folder of pictures, removed when the server ends."""
        return tempfile.TemporaryDirectory(prefix="wmspec-")

    def close(self) -> None:
        """Stop the process and remove the pictures."""
        if "drawer" in self.__dict__:
            self.drawer.close()
        if "pictures" in self.__dict__:
            self.pictures.cleanup()


def read(path: Path) -> str:
    """Return the text of a file; "" if it cannot be read."""
    try:
        return read_text(path)
    except (OSError, UnicodeDecodeError):
        return ""


def serve() -> None:
    """Serve on standard input and output until the client disconnects."""
    from wmspec.editor.features import COMMANDS, FEATURES

    logging.getLogger("pygls").setLevel(logging.ERROR)
    # Libraries and syntax trees are long-lived; the default threshold of 700 costs 10 % of each check.
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
