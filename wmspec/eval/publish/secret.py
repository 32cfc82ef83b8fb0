"""The secret of who holds the answers: it hides the ids of questions and signs receipts."""

from __future__ import annotations

import hashlib
import hmac
import json
import os
import secrets
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import make_folders, regular_file

#: First word of a file with a secret, and its size in hexadecimal digits.
_MARK, _DIGITS = "wmspec-secret-1", 64


class Secret:
    """A secret of 32 bytes."""

    def __init__(self, key: bytes) -> None:
        self._key = key

    @classmethod
    def read(cls, path: Path) -> Secret:
        """Read a secret. Raises WmsError if the file is missing or holds none."""
        try:
            mark, _, digits = regular_file(path).read_text(encoding="ascii").strip().partition(" ")
            key = bytes.fromhex(digits)
        except FileNotFoundError:
            raise WmsError(f"{path} is not there; `wmspec export --to questions --secret {path}` makes it") from None
        except (OSError, ValueError):
            mark, key = "", b""
        if mark != _MARK or len(key) * 2 != _DIGITS:
            raise WmsError("this is no secret of wmspec", FilePlace(str(path)), "give the file of --secret")
        return cls(key)

    @classmethod
    def open_or_create(cls, path: Path) -> Secret:
        """Read a secret, or create one in a new file that only its owner may read."""
        if path.exists():
            return cls.read(path)
        make_folders(path.parent)
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w", encoding="ascii") as file:
            file.write(f"{_MARK} {secrets.token_hex(_DIGITS // 2)}\n")
        return cls.read(path)

    def public_id(self, task: str, id: str) -> str:
        """Return the public id of a question, from which its own id does not follow."""
        return f"{task}/{self._digest(b'id', id.encode())[:20]}"

    def sign(self, content: dict[str, Any]) -> str:
        """Return the signature of a JSON object: HMAC-SHA256 of its canonical form."""
        return self._digest(b"receipt", canonical(content))

    def is_signed(self, content: dict[str, Any], signature: object) -> bool:
        """Whether the signature is that of the object."""
        given = signature.encode(errors="replace") if isinstance(signature, str) else b""
        return hmac.compare_digest(self.sign(content).encode(), given)

    def _digest(self, purpose: bytes, message: bytes) -> str:
        return hmac.new(self._key, purpose + b"\0" + message, hashlib.sha256).hexdigest()


def canonical(content: Any) -> bytes:
    """Return JSON with sorted keys and without white space."""
    return json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()
