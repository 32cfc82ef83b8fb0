"""A page as one file: a template with its style, script and data, which loads nothing that is not beside it."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

#: What a page may do: run its own script, use its own style, show the pictures beside it, and ask who served it.
_POLICY = (
    "default-src 'none'; script-src {script}; style-src {style}; img-src 'self' data: blob: file:; "
    "connect-src 'self'; form-action 'none'; base-uri 'none'"
)


def webpage(package: str, *, scripts_beside: bool = False, shaded: bool = False, **values: Any) -> str:
    """The page that `page.html` of a package makes with `values`, with its `page.css` and `page.js` inside.

    Every value is escaped where it is put in, and `data` becomes JSON for the script. A policy names style and script
    by their hashes, so that nothing else runs, whatever the values hold; with `scripts_beside`, files of the page's own
    folder do too, and with `shaded`, elements may have a style of their own.
    """
    style = _part(__package__, "base.css") + _part(package, "page.css")
    script = _part(package, "page.js")
    policy = _POLICY.format(
        script=(_hash(script) if script else "'none'") + (" 'self' file:" if scripts_beside else ""),
        style=_hash(style) + ("; style-src-attr 'unsafe-inline'" if shaded else ""),
    )
    if "data" in values:
        values["data"] = encoded(values["data"])
    return _templates(package).get_template("page.html").render(values, policy=policy, style=style, script=script)


def encoded(data: Any) -> str:
    """JSON that may stand in a script element."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


@cache
def _templates(package: str) -> Environment:
    """The templates of a package and those that all pages share; `value | fmt(",")` formats as Python does."""
    templates = Environment(
        loader=ChoiceLoader([PackageLoader(package, ""), PackageLoader(__package__, "")]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    templates.filters["fmt"] = format
    return templates


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


@cache
def _part(package: str, name: str) -> str:
    """The text of a file of a package; empty if there is none."""
    place = files(package) / name
    return place.read_text(encoding="utf-8") if place.is_file() else ""
