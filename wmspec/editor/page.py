"""The page of `wmspec watch`, served on the loopback address; server-sent events update it."""

from __future__ import annotations

import json
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from threading import Lock

from wmspec.core.bounded_server import BoundedServer
from wmspec.core.diagnostics import Diagnostic, WmsError
from wmspec.dataset.build.webpage import webpage
from wmspec.editor.trial import try_spec
from wmspec.editor.watch import Watch, picture_name

HOST = "127.0.0.1"
#: Seconds without news after which a comment is sent, to detect closed pages.
HEARTBEAT = 5.0
#: The content-security policy: the page loads nothing from other hosts.
POLICY = "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; script-src 'self' 'unsafe-inline'"
#: The most connections at a time: a page has one for its events, and a few for its pictures.
MAX_CONNECTIONS = 32
#: Timeout (s) of a silent connection.
CONNECTION_TIMEOUT = 10.0


class PageServer(BoundedServer):
    """Serves the page of a watch at `url`. Raises WmsError if the port is taken."""

    max_connections = MAX_CONNECTIONS

    def __init__(self, watch: Watch, port: int) -> None:
        self.watch = watch
        self.trying = Lock()
        try:
            super().__init__((HOST, port), _Handler)
        except OSError as error:
            what = f"port {port} of {HOST} cannot be used: {error.strerror}"
            raise WmsError(what, help="choose another one with `--port`; 0 selects a free one") from None

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://{HOST}:{self.server_address[1]}/"


class _Handler(BaseHTTPRequestHandler):
    server: PageServer
    timeout = CONNECTION_TIMEOUT

    def do_GET(self) -> None:
        if self.headers.get("Host", "").rpartition(":")[0] not in (HOST, "localhost"):  # DNS rebinding
            self.send_error(HTTPStatus.FORBIDDEN)
        elif self.path == "/":
            self._send("text/html; charset=utf-8", page(self.server.watch.path.name).encode())
        elif self.path == "/events":
            self._events()
        elif self.path == "/trial":
            watch = self.server.watch
            self.server.keep_open(self.request)
            with self.server.trying:  # one trial at a time
                self._send("text/plain; charset=utf-8", try_spec(watch.path, watch.options.engine).encode())
        elif (png := self.server.watch.png(self.path.rpartition("/")[2].removesuffix(".png"))) is not None:
            self._send("image/png", png)
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def log_message(self, format: str, *args: object) -> None:
        """Log nothing."""

    def _send(self, kind: str, content: bytes) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("Content-Security-Policy", POLICY)
        self.end_headers()
        self.wfile.write(content)

    def _events(self) -> None:
        """Send each new state as a server-sent event."""
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.server.keep_open(self.request)
        version, watch = -1, self.server.watch
        try:
            while not watch.stopped.is_set():
                state = watch.after(version, HEARTBEAT)
                version = state.version if state else version
                news = f"data: {json.dumps(state, default=to_json)}\n\n" if state else ": still here\n\n"
                self.wfile.write(news.encode())
                self.wfile.flush()
        except OSError:  # the page was closed
            return


def page(name: str) -> str:
    """Return the HTML page for a spec with this name."""
    return webpage("wmspec.editor", name=name)


def to_json(value: object) -> object:
    """Convert a value that JSON lacks: a picture to its URL, a diagnostic to its text, a record to its fields."""
    match value:
        case bytes():
            return f"pictures/{picture_name(value)}.png" if value else ""
        case Diagnostic():
            return {"severity": value.severity, "text": value.render()}
    return vars(value)
