"""A small server for a study: its page and pictures, and two requests: begin, and answer."""

from __future__ import annotations

import ipaddress
import json
import re
import sqlite3
from dataclasses import asdict
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from wmspec.core.bounded_server import BoundedServer
from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import FILE_BYTES
from wmspec.core.safe_io import is_within, read_bytes
from wmspec.eval.study import page, store
from wmspec.eval.study.answers import Answer, Person
from wmspec.eval.study.model import PAGE_FOLDER, Study, load
from wmspec.eval.study.store import AnswerStore, StudyFull

#: Maximum size of a request (bytes), and timeout of a silent connection (s).
MAX_REQUEST_BYTES, CONNECTION_TIMEOUT = 4096, 10.0


class StudyServer(BoundedServer):
    """The server of a study; `serve_forever` runs it."""

    def __init__(self, folder: Path, host: str, port: int, shares: int | None = None) -> None:
        """Open the study and listen; new people get one of the first `shares` slots.

        Raises WmsError if there is no study, or if the address is unavailable.
        """
        self.study: Study = load(folder)
        self.page = page.html(self.study, folder, served=True).encode()
        items, self.folder = self.study.items, folder / PAGE_FOLDER
        pictures = {name for item in items for name in (*item.context, *item.pictures)}
        self.files = {f"/pictures/{name}": self.folder / "pictures" / Path(name).name for name in pictures}
        self.files |= {
            f"/films/{item.film}": self.folder / "films" / Path(item.film).name for item in items if item.film
        }
        self.store = AnswerStore(folder / store.ANSWERS_FILE, self.study, shares)
        self.is_local = _is_loopback(host)
        try:
            super().__init__((host, port), partial(_Handler))
        except OSError as error:
            self.store.close()
            raise WmsError(f"{host}:{port} is not available: {error.strerror or error}; try another --port") from None

    @property
    def url(self) -> str:
        """The URL of the page."""
        return f"http://{self.server_address[0]!s}:{self.server_address[1]}/"

    def content(self, path: str) -> bytes:
        """Return a picture or film of the page. Raises OSError if it is unreadable, or a link that leads elsewhere."""
        file = self.files[path]
        if not is_within(self.folder, file):
            raise FileNotFoundError(file)
        return read_bytes(file, FILE_BYTES)

    def server_close(self) -> None:
        """Stop listening, and close the file of answers."""
        super().server_close()
        self.store.close()


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _part_of(content: bytes, requested: str) -> tuple[HTTPStatus, bytes, dict[str, str]]:
    """Return the part of a file that a `Range` header names, with its headers; the whole file for any other header.

    Some browsers play films only if they can ask for parts (RFC 9110, section 14).
    """
    match = re.fullmatch(r"bytes=(\d{1,12})-(\d{0,12})", requested, re.ASCII)
    if match is None or int(match[1]) >= len(content) or (match[2] and int(match[2]) < int(match[1])):
        return HTTPStatus.OK, content, {"Accept-Ranges": "bytes"}
    first, last = int(match[1]), min(int(match[2] or len(content)), len(content) - 1)
    headers = {"Accept-Ranges": "bytes", "Content-Range": f"bytes {first}-{last}/{len(content)}"}
    return HTTPStatus.PARTIAL_CONTENT, content[first : last + 1], headers


class _Handler(BaseHTTPRequestHandler):
    """One connection."""

    server: StudyServer
    server_version, sys_version = "wmspec", ""
    protocol_version = "HTTP/1.1"
    timeout = CONNECTION_TIMEOUT

    def do_GET(self) -> None:
        """Send the page, or one of its pictures or films; no other file is accessible."""
        path = self.path.partition("?")[0]
        if not self._has_own_host():
            return
        if path == "/":
            self._send(HTTPStatus.OK, self.server.page, "text/html; charset=utf-8")
        elif path in self.server.files:
            try:
                content = self.server.content(path)
            except OSError:
                self._refuse(HTTPStatus.NOT_FOUND, "not here")
                return
            kind = "video/mp4" if path.startswith("/films/") else "image/png"
            status, content, part = _part_of(content, self.headers.get("Range", ""))
            self._send(status, content, kind, "public, max-age=86400", part)
        else:
            self._refuse(HTTPStatus.NOT_FOUND, "not here")

    def do_POST(self) -> None:
        """Begin or resume a visit, accept an answer, or delete all answers of a visit."""
        body = self._body()
        if body is None:
            return
        try:
            place = self._handle(body)
        except (ValidationError, ValueError):
            self._refuse(HTTPStatus.BAD_REQUEST, "not understood")
        except sqlite3.Error:
            self._refuse(HTTPStatus.SERVICE_UNAVAILABLE, "cannot be kept now")
        except StudyFull:
            self._refuse(HTTPStatus.GONE, "all questions have been answered")
        else:
            if place is None:
                self._refuse(HTTPStatus.CONFLICT, "no such visit or question")
            else:
                self._json(HTTPStatus.OK, place)

    def _handle(self, body: bytes) -> dict[str, Any] | None:
        match self.path.split("/"):
            case ["", "visits"]:
                return asdict(self.server.store.begin(Person.model_validate_json(body)))
            case ["", "visits", session, "answers"]:
                place = self.server.store.keep(session, Answer.model_validate_json(body))
                return asdict(place) if place else None
            case ["", "visits", session, "withdrawal"]:
                return {"withdrawn": True} if self.server.store.withdraw(session) else None
        return None

    def _has_own_host(self) -> bool:
        """Whether the request names the server's own address; prevents DNS rebinding by other sites."""
        name = re.sub(r":\d+$", "", self.headers.get("Host", "")).strip("[]")
        if not self.server.is_local or _is_loopback(name):
            return True
        self._refuse(HTTPStatus.MISDIRECTED_REQUEST, "call it by its address")
        return False

    def _body(self) -> bytes | None:
        """Return the request's JSON, None if refused. Other sites cannot send this content type without permission."""
        if not self._has_own_host():
            return None
        if self.headers.get_content_type() != "application/json":
            self._refuse(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "JSON is expected")
            return None
        length = self.headers.get("Content-Length", "")
        if not re.fullmatch(r"\d{1,9}", length, re.ASCII):
            self._refuse(HTTPStatus.LENGTH_REQUIRED, "a length is expected")
            return None
        if int(length) > MAX_REQUEST_BYTES:
            self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "too long")
            return None
        return self.rfile.read(int(length))

    def _refuse(self, status: HTTPStatus, why: str) -> None:
        self.close_connection = True  # the rest of the request is not read
        self._json(status, {"error": why})

    def _json(self, status: HTTPStatus, value: dict[str, Any]) -> None:
        self._send(status, json.dumps(value).encode(), "application/json")

    def _send(
        self, status: HTTPStatus, content: bytes, kind: str, cache: str = "no-store", part: dict[str, str] | None = None
    ) -> None:
        self.send_response(status)
        for name, value in (
            ("Content-Type", kind),
            ("Content-Length", str(len(content))),
            ("Cache-Control", cache),
            ("X-Content-Type-Options", "nosniff"),
            ("X-Frame-Options", "DENY"),
            ("Referrer-Policy", "no-referrer"),
            *(part or {}).items(),
            *((("Connection", "close"),) if self.close_connection else ()),
        ):
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:
        """Log nothing, to protect the privacy of visitors."""
