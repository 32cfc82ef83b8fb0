"""A server on the loopback address that answers chats as vision models do, rightly, wrongly and not at all.

Its rules are in the model's name, joined by `+`: `first` (the first option), `right` (as its caller says), `chatty`,
`lower`, `empty`, `refuse`, `odd` (bytes that no text has), `long`, `huge`, `garbage` (no JSON), `echo` (of the key),
`slow`, `structured` (what the schema of the request allows first); `429`, `500` and `drop` fail the first two tries of
each request; `down` and `401` fail all.
"""

from __future__ import annotations

import hashlib
import json
import re
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

TRIES = 2

Answer = Callable[[list[Any]], str]
"""What is said of the parts of a turn."""


@dataclass
class Loopback:
    """A running server: what it was sent, by request; `right` is asked by the rule of that name."""

    address: str
    right: Answer | None = None
    tries: Counter[str] = field(default_factory=Counter)
    bodies: list[dict[str, Any]] = field(default_factory=list)
    keys: set[str] = field(default_factory=set)
    lock: threading.Lock = field(default_factory=threading.Lock)


def first(parts: list[Any]) -> str:
    """The first label that the request shows, or a number."""
    text = "\n".join(part["text"] for part in parts if part["type"] == "text")
    labels = re.findall(r"(?m)^([A-Z]|\d)\.(?:$| )", text)
    return labels[0] if labels else "The number is 1"


class _Server(ThreadingHTTPServer):
    request_queue_size = 256
    daemon_threads = True
    said: Loopback

    def handle_error(self, request: object, client_address: object) -> None:
        """A client that hangs up is no news."""


class _Handler(BaseHTTPRequestHandler):
    server: _Server

    protocol_version = "HTTP/1.1"

    def log_message(self, *args: object) -> None:
        """Nothing is printed."""

    def send(self, code: int, content: bytes, **headers: str) -> None:
        self.send_response(code)
        for name, value in {"Content-Type": "application/json", **headers}.items():
            self.send_header(name.replace("_", "-"), value)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def do_GET(self) -> None:
        listed = {"object": "list", "data": [{"id": "first", "object": "model", "owned_by": "loopback"}]}
        self.send(200, json.dumps(listed).encode())

    def do_POST(self) -> None:
        raw = self.rfile.read(int(self.headers["Content-Length"]))
        body = json.loads(raw)
        digest = hashlib.sha256(raw).hexdigest()
        said = self.server.said
        with said.lock:
            said.tries[digest] += 1
            said.bodies.append(body)
            said.keys.add(self.headers.get("Authorization", ""))
            tries = said.tries[digest]
        self.answer(body, set(body["model"].split("/")[-1].split("+")), tries)

    def answer(self, body: dict[str, Any], rules: set[str], tries: int) -> None:
        if "slow" in rules:
            time.sleep(0.05)
        failing = tries <= TRIES
        if "401" in rules or "down" in rules:
            key = self.headers.get("Authorization", "")
            self.send(401 if "401" in rules else 500, json.dumps({"error": {"message": f"no: {key}"}}).encode())
        elif "429" in rules and failing:
            self.send(429, b'{"error": {"message": "slow down"}}', retry_after="0.01")
        elif "500" in rules and failing:
            self.send(500, b'{"error": {"message": "broken"}}', retry_after="0.01")
        elif "drop" in rules and failing:
            self.close_connection = True
            self.connection.close()
        elif "garbage" in rules:
            self.send(200, b"<html>welcome</html>", Content_Type="text/html")
        else:
            self.send(200, self.completion(body, rules))

    def completion(self, body: dict[str, Any], rules: set[str]) -> bytes:
        parts = body["messages"][-1]["content"]
        parts = [{"type": "text", "text": parts}] if isinstance(parts, str) else parts
        said = self.server.said
        text = said.right(parts) if "right" in rules and said.right else first(parts)
        if "structured" in rules:
            answer = body["response_format"]["json_schema"]["schema"]["properties"]["answer"]
            text = json.dumps({"answer": answer.get("enum", [0.5])[0]})
        if "chatty" in rules:
            text = f"Let me look at {len(parts)} things. The answer is ({text}), for A ball moves, as it seems."
        for rule, changed in {
            "lower": text.lower(),
            "empty": "",
            "echo": f"{text}. You sent {self.headers.get('Authorization')}",
            "huge": "B " * 8_000_000,
            "long": "B" + " " * 200_000,
        }.items():
            text = changed if rule in rules else text
        content = json.dumps(text)[1:-1] + ("\\ud800 \\u0000 \\u202e" if "odd" in rules else "")
        return (
            '{"id": "c", "object": "chat.completion", "created": 1, "model": "loopback-1", "choices": [{"index": 0,'
            f'"finish_reason": "{"content_filter" if "refuse" in rules else "stop"}",'
            f'"message": {{"role": "assistant", "content": "{content}"}}}}],'
            '"usage": {"prompt_tokens": 1000, "completion_tokens": 10, "total_tokens": 1010}}'
        ).encode()


@contextmanager
def serving(server: ThreadingHTTPServer) -> Iterator[str]:
    """Serve until the block ends; the address of its API."""
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}/v1"
    finally:
        server.shutdown()
        server.server_close()


@contextmanager
def loopback(right: Answer | None = None) -> Iterator[Loopback]:
    """A server on a free port, until the block ends."""
    said = Loopback("", right)
    server = _Server(("127.0.0.1", 0), _Handler)
    server.said = said
    with serving(server) as said.address:
        yield said


if __name__ == "__main__":
    with loopback() as running:
        print(running.address, flush=True)
        threading.Event().wait()
