"""Finds unused declarations of a file: values, cameras, templates."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator

from wmspec.core.diagnostics import Report
from wmspec.lang.parse import syntax as s

_WORD = re.compile(r"[A-Za-z_]\w*")


def warn_unused(file: s.File, report: Report) -> None:
    """Warn about unused declarations of a file. A name that occurs in a text counts as used."""
    if not any(isinstance(item, s.Task) for item in file.items) or not file.whole:
        return
    used = Counter(name.id for name in s.names(file.items))
    used.update(word for text in _texts(file.items) for word in _WORD.findall(text))
    for item in _declared(file.items):
        what = "template" if isinstance(item, s.Template) else "camera" if isinstance(item, s.Block) else "value"
        if used[item.name.id] == 1:
            message = f"the {what} `{item.name.id}` is never used"
            report.add("WMS410", message, item.name.span, "use it, or remove it", severity="warning")


def _declared(items: Iterable[object]) -> Iterator[s.Let | s.Block | s.Template]:
    for item in items:
        if isinstance(item, s.Task | s.Variant):
            yield from _declared(item.body)
        elif isinstance(item, s.Let | s.Template) or (isinstance(item, s.Block) and item.kind == "camera"):
            yield item


def _texts(node: object) -> Iterator[str]:
    return (text.value for text in s.texts(node))
