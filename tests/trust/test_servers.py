"""Servers keep a bounded number of connections, each for a bounded time, and serve again afterwards."""

from __future__ import annotations

import http.client
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from http.server import BaseHTTPRequestHandler

import pytest

from wmspec.core.bounded_server import BoundedServer


class _Small(BoundedServer):
    max_connections = 4


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Length", "2")
        self.end_headers()
        self.wfile.write(b"ok")

    def log_message(self, format: str, *args: object) -> None:
        """Log nothing."""


@pytest.fixture
def server() -> Iterator[_Small]:
    with _Small(("127.0.0.1", 0), _Handler) as one:
        thread = threading.Thread(target=one.serve_forever)
        thread.start()
        yield one
        one.shutdown()
        thread.join()


def status(server: _Small) -> int:
    while server._opened:  # a visitor sees the end of a connection before its thread has freed the place
        time.sleep(0.01)
    visitor = http.client.HTTPConnection("127.0.0.1", server.server_address[1], timeout=20)
    try:
        visitor.request("GET", "/")
        return visitor.getresponse().status
    finally:
        visitor.close()


def connection(server: _Small) -> socket.socket:
    return socket.create_connection(("127.0.0.1", server.server_address[1]), timeout=20)


def test_connections_beyond_the_limit_are_refused_and_silent_ones_end(server: _Small) -> None:
    with ExitStack() as stack:
        held = [stack.enter_context(connection(server)) for _ in range(4)]
        for one in held:
            one.sendall(b"GET / HT")  # the beginning of a request, and no more
        further = [stack.enter_context(connection(server)) for _ in range(20)]
        assert all(one.recv(100).startswith(b"HTTP/1.1 503") for one in further)
        assert len(server._opened) == 4, "refused ones have no thread"
        server.max_seconds = 0.0  # now their time is over
        assert all(one.recv(100) == b"" for one in held)
    server.max_seconds = 60.0
    assert [status(server) for _ in range(5)] == [200] * 5
