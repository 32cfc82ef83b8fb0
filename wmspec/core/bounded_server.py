"""An HTTP server with a bounded number of connections, each with a bounded time."""

from __future__ import annotations

import socket
import sys
from contextlib import suppress
from http.server import ThreadingHTTPServer
from threading import Lock
from time import monotonic
from typing import Any

from wmspec.core.crash import tell

_BUSY = (
    b"HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nRetry-After: 1\r\n"
    b"Content-Type: text/plain\r\nContent-Length: 4\r\n\r\nbusy"
)


class BoundedServer(ThreadingHTTPServer):
    """Serves each connection in a thread, at most `max_connections`; closes those that are open longer than the limit.

    Further connections receive status 503. The time limit is `max_seconds` (s); `serve_forever` looks for late
    connections every half second. A handler that sends for longer by design calls `keep_open`.
    """

    daemon_threads = True
    max_connections = 256
    max_seconds = 60.0

    def __init__(self, address: tuple[str, int], handler: Any) -> None:
        self._opened: dict[socket.socket, float] = {}
        self._lock = Lock()
        super().__init__(address, handler)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Start the thread of a connection, or refuse it."""
        with self._lock:
            full = len(self._opened) >= self.max_connections
            if not full:
                self._opened[request] = monotonic()
        if full:
            self._refuse(request)
        else:
            super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Close a connection."""
        with self._lock:
            self._opened.pop(request, None)
        super().shutdown_request(request)

    def service_actions(self) -> None:
        """Close connections whose time is over."""
        now = monotonic()
        with self._lock:
            late = [request for request, since in self._opened.items() if now - since > self.max_seconds]
        for request in late:  # its thread notices the end and closes it
            with suppress(OSError):
                request.shutdown(socket.SHUT_RDWR)

    def keep_open(self, request: socket.socket) -> None:
        """Exempt a connection from the time limit."""
        with self._lock:
            self._opened[request] = float("inf")

    def handle_error(self, request: Any, client_address: Any) -> None:  # noqa: ARG002  the signature of the base class
        """Ignore connections that visitors closed; report other exceptions."""
        error = sys.exception()
        if error is not None and not isinstance(error, OSError):
            tell(error)

    def _refuse(self, request: socket.socket) -> None:
        """Answer that the server is busy, without waiting for the visitor."""
        with suppress(OSError):
            request.setblocking(False)
            request.send(_BUSY)
            request.recv(1 << 16)  # unread data would reset the connection before the answer arrives
        super().shutdown_request(request)
