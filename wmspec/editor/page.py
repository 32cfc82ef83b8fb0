"""The page of `wmspec watch`, served on the loopback address: the server tells every open page what is new."""

from __future__ import annotations

import json
import sys
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from wmspec.core.crash import tell
from wmspec.core.diagnostics import Diagnostic, WmsError
from wmspec.dataset.build.webpage import webpage
from wmspec.editor.examples import Cell, Row
from wmspec.editor.watch import State, Watch, picture_name

HOST = "127.0.0.1"
#: After so many seconds without news, a word is sent, which tells whether anyone still listens.
HEARTBEAT = 5.0
#: The page takes nothing from anywhere else.
POLICY = "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; script-src 'self' 'unsafe-inline'"


class PageServer(ThreadingHTTPServer):
    """Serves the page of a watch; `url` is where it is. Raises WmsError if the port is taken."""

    daemon_threads = True

    def __init__(self, watch: Watch, port: int) -> None:
        self.watch = watch
        try:
            super().__init__((HOST, port), _Handler)
        except OSError as error:
            what = f"port {port} of {HOST} cannot be used: {error.strerror}"
            raise WmsError(what, help="choose another with `--port`; 0 takes any that is free") from None

    @property
    def url(self) -> str:
        """Where the page is."""
        return f"http://{HOST}:{self.server_address[1]}/"

    def handle_error(self, request: Any, client_address: Any) -> None:  # noqa: ARG002  as the base class has it
        """A page that was closed is no error."""
        error = sys.exception()
        if error is not None and not isinstance(error, OSError):
            tell(error)


class _Handler(BaseHTTPRequestHandler):
    server: PageServer

    def do_GET(self) -> None:
        if self.headers.get("Host", "").rpartition(":")[0] not in (HOST, "localhost"):  # a name that was bent to here
            self.send_error(HTTPStatus.FORBIDDEN)
        elif self.path == "/":
            self._send("text/html; charset=utf-8", page(self.server.watch.path.name).encode())
        elif self.path == "/events":
            self._events()
        elif (png := self.server.watch.png(self.path.rpartition("/")[2].removesuffix(".png"))) is not None:
            self._send("image/png", png)
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing of requests."""

    def _send(self, kind: str, content: bytes) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("Content-Security-Policy", POLICY)
        self.end_headers()
        self.wfile.write(content)

    def _events(self) -> None:
        """Server-sent events: the state, whenever there is a new one."""
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        version, watch = -1, self.server.watch
        try:
            while not watch.stopped.is_set():
                state = watch.after(version, HEARTBEAT)
                version = state.version if state else version
                news = f"data: {json.dumps(record(state))}\n\n" if state else ": still here\n\n"
                self.wfile.write(news.encode())
                self.wfile.flush()
        except OSError:  # the page was closed
            return


def page(name: str) -> str:
    """The page, for a spec of this name."""
    return webpage("wmspec.editor", name=name)


def record(state: State) -> dict[str, object]:
    """A state as JSON values; pictures by their names."""
    return {
        "version": state.version,
        "phase": state.phase,
        "stale": state.stale,
        "tasks": [{"name": name, "instances": count} for name, count in state.tasks],
        "diagnostics": [_diagnostic(d) for d in state.diagnostics],
        "rows": [_row(row) for row in state.rows],
    }


def _diagnostic(diagnostic: Diagnostic) -> dict[str, object]:
    return {"severity": diagnostic.severity, "text": diagnostic.render()}


def _row(row: Row) -> dict[str, object]:
    return {
        "task": row.task,
        "index": row.index,
        "factors": row.factors,
        "asked": [
            {
                "text": asked.text,
                "rejected": asked.rejected,
                "shown": [_cell(c) for c in asked.shown],
                "options": [_cell(c) for c in asked.options],
            }
            for asked in row.asked
        ],
    }


def _cell(cell: Cell) -> dict[str, object]:
    picture = f"pictures/{picture_name(cell.png)}.png" if cell.png else ""
    return {"caption": cell.caption, "text": cell.text, "picture": picture, "true": cell.true}
