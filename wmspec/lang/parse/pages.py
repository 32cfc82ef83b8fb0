"""Pages of the diagnostic codes: meaning, an example that triggers the code, and the corrected example."""

from __future__ import annotations

import re
from dataclasses import dataclass
from importlib.resources import files

from wmspec.lang.parse.codes import CODES

_FENCE = re.compile(r"^```wms *(\S*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Example:
    """A spec as text, and the libraries next to it by file name."""

    text: str
    libraries: dict[str, str]


@dataclass(frozen=True)
class Page:
    """The page of a code; `markdown` is the whole page, the other fields are extracted from it."""

    code: str
    title: str
    markdown: str
    wrong: Example
    right: Example


def page(code: str) -> Page:
    """Return the page of a code of `CODES`. Raises KeyError for unknown codes."""
    if code not in CODES:
        raise KeyError(code)
    markdown = files("wmspec").joinpath(f"lang/parse/codes/{code}.md").read_text(encoding="utf-8")
    parts = dict(re.findall(r"^## ([^\n]+)\n(.*?)(?=^## |\Z)", markdown, re.MULTILINE | re.DOTALL))
    title = markdown.partition("\n")[0].partition(": ")[2]
    return Page(code, title, markdown, _example(parts["Wrong"]), _example(parts["Right"]))


def _example(markdown: str) -> Example:
    texts = dict(_FENCE.findall(markdown))
    return Example(texts.pop(""), texts)
