"""Self-contained web pages: a template with its style, script and data in one file."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

#: Content security policy: own script and style, pictures and films of the same folder, requests to the own server.
_POLICY = (
    "default-src 'none'; script-src {script}; style-src {style}; img-src 'self' data: blob: file:; "
    "media-src 'self' data: file:; connect-src 'self'; form-action 'none'; base-uri 'none'"
)


def webpage(package: str, *, scripts_beside: bool = False, shaded: bool = False, **values: Any) -> str:
    """Render `page.html` of a package with `values`, including its `page.css` and `page.js` after the shared ones.

    Values are escaped, and `data` becomes JSON for the script. The content security policy names style and script by
    their hashes, so that no other script can run. `scripts_beside` also permits files of the
    page's folder, `shaded` permits style attributes.
    """
    style = _package_text(__package__, "base.css") + _package_text(package, "page.css")
    own = _package_text(package, "page.js")
    script = own and _package_text(__package__, "base.js") + own
    policy = _POLICY.format(
        script=(_hash(script) if script else "'none'") + (" 'self' file:" if scripts_beside else ""),
        style=_hash(style) + ("; style-src-attr 'unsafe-inline'" if shaded else ""),
    )
    if "data" in values:
        values["data"] = json_for_script(values["data"])
    return _templates(package).get_template("page.html").render(values, policy=policy, style=style, script=script)


def json_for_script(data: Any) -> str:
    """Return JSON that is safe inside a script element."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


@cache
def _templates(package: str) -> Environment:
    """Return the templates of a package and the shared ones; `value | fmt(",")` formats as Python does."""
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
    """Return the CSP hash of a text."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


@cache
def _package_text(package: str, name: str) -> str:
    """Return the text of a package file; empty if there is none."""
    place = files(package) / name
    return place.read_text(encoding="utf-8") if place.is_file() else ""
