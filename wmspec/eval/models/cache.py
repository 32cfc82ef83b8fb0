"""Cache of replies by request content, shared by all runs that name the same file."""

from __future__ import annotations

import hashlib
import json
import sqlite3
import threading
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import make_folders, regular_file
from wmspec.eval.models.model import Model, Reply
from wmspec.eval.models.request import Ask


class CachedModel:
    """A model with a cache of its replies in a file. Cached replies cost nothing."""

    def __init__(self, model: Model, parameters: dict[str, Any], path: Path) -> None:
        """Open or create the cache. Raises WmsError if the file is no cache or cannot be written."""
        self.identity, self.asks = model.identity, model.asks
        self._model, self._path = model, path
        self._identity = json.dumps([model.identity, parameters], sort_keys=True)
        self._turn = threading.Lock()
        try:
            make_folders(path.parent)
            self._file = sqlite3.connect(regular_file(path, new=True), timeout=60, check_same_thread=False)
            self._file.execute("CREATE TABLE IF NOT EXISTS replies (key TEXT PRIMARY KEY, reply TEXT NOT NULL)")
        except (OSError, sqlite3.Error) as error:
            raise WmsError(f"--cache {path}: cannot be used ({error}); name another file") from None

    @property
    def notes(self) -> tuple[str, ...]:
        """Those of the model."""
        return self._model.notes

    def reply(self, ask: Ask) -> Reply:
        """Return the cached reply, or the model's, which is cached unless it is an error."""
        key = hashlib.sha256(f"{self._identity}\n{ask.request.digest}\n{ask.sample}".encode()).hexdigest()
        known = self._run("SELECT reply FROM replies WHERE key = ?", key)
        if known:
            stored = json.loads(known[0][0])
            if stored.pop("outcome", "ok") == "refused":  # written by earlier versions
                stored["finish"] = "content_filter"
            return replace(Reply(**stored), cost=0.0)
        reply = self._model.reply(ask)
        if not reply.failed:
            self._run("INSERT OR REPLACE INTO replies VALUES (?, ?)", key, json.dumps(asdict(reply)))
        return reply

    def _run(self, command: str, *values: str) -> list[Any]:
        try:
            with self._turn, self._file:
                return self._file.execute(command, values).fetchall()
        except sqlite3.Error as error:
            raise WmsError(f"--cache {self._path}: cannot be used ({error}); name another file") from None
