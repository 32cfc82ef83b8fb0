"""A page as one file: a template with its style, script and data, which loads nothing that is not beside it."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from importlib.resources import files
from typing import Any

#: What a page may do: run its own script, use its own style, show the pictures beside it, and ask who served it.
_POLICY = (
    "default-src 'none'; script-src {script}{beside}; style-src {style}; img-src 'self' data: blob: file:; "
    "connect-src 'self'; form-action 'none'; base-uri 'none'"
)


def webpage(package: str, data: Any, scripts_beside: bool = False) -> str:
    """The page that `page.html`, `page.css` and `page.js` of a package make with `data`.

    No text of the data can end the element that it is in. A policy names style and script by their hashes, so that
    nothing else runs, whatever the data hold; with `scripts_beside`, files of the page's own folder do too.
    """
    parts = {name: _part(package, name) for name in ("page.css", "page.js")}
    policy = _POLICY.format(
        script=_hash(parts["page.js"]),
        style=_hash(parts["page.css"]),
        beside=" 'self' file:" if scripts_beside else "",
    )
    values = {"policy": policy, "style": parts["page.css"], "script": parts["page.js"], "data": encoded(data)}
    return re.sub(r"\{\{ (\w+) \}\}", lambda match: values[match[1]], _part(package, "page.html"))


def encoded(data: Any) -> str:
    """JSON that may stand in a script element."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _part(package: str, name: str) -> str:
    return (files(package) / name).read_text(encoding="utf-8")
