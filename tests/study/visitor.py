"""A visitor without a browser, and a server in a process of its own that can be killed."""

from __future__ import annotations

import http.client
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from wmspec.eval.replies import LETTERS
from wmspec.eval.study.model import Study


class Process:
    """`wmspec study serve`, on a port that stays the same when it is begun again."""

    def __init__(self, folder: Path, environment: dict[str, str] | None = None) -> None:
        self.folder, self.port, self.environment = folder, 0, environment
        self.begin()

    def begin(self) -> None:
        command = [sys.executable, "-m", "wmspec", "study", "serve", str(self.folder), "--port", str(self.port)]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.environment
        )
        assert self.process.stdout is not None
        said = self.process.stdout.readline()
        assert said, self.process.stderr and self.process.stderr.read()
        self.url = said.split()[0]
        self.port = int(self.url.rstrip("/").rpartition(":")[2])

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()


def post(port: int, path: str, body: Any, **headers: str) -> tuple[int, Any]:
    """Status and JSON of a request. Raises OSError or HTTPException if the server is gone."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=600)
    try:
        content = body if isinstance(body, bytes) else json.dumps(body).encode()
        connection.request("POST", path, content, {"Content-Type": "application/json", **headers})
        reply = connection.getresponse()
        return reply.status, json.loads(reply.read() or b"null")
    finally:
        connection.close()


def get(port: int, path: str, **headers: str) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=600)
    try:
        connection.request("GET", path, headers=headers)
        reply = connection.getresponse()
        return reply.status, reply.read()
    finally:
        connection.close()


def letter(study: Study, slot: int, step: int, off: int = 0) -> str:
    """The letter under which the true option of a step is shown, or of one that is `off` places further."""
    shown = study.step(slot, step)
    assert shown is not None
    item, permutation = shown
    assert item.answer is not None
    return LETTERS[(item.order(permutation).index(item.answer) + off) % len(item.options)]
