"""Finds unused declarations of a file: values, cameras, templates."""

from __future__ import annotations

import re
from collections import Counter

from wmspec.core.diagnostics import Report
from wmspec.lang.parse import syntax as s

_WORD = re.compile(r"[A-Za-z_]\w*")


def warn_unused(file: s.File, report: Report) -> None:
    """Warn about unused declarations of a file. A name that occurs in a text counts as used."""
    if not any(isinstance(item, s.Task) for item in file.items) or not file.whole:
        return
    used = Counter(name.id for name in s.nodes(file.items, s.Name))
    used.update(word for text in s.nodes(file.items, s.Text) for word in _WORD.findall(text.value))
    for item in s.statements(file.items):
        if not (isinstance(item, s.Let | s.Template) or (isinstance(item, s.Block) and item.kind == "camera")):
            continue
        what = "template" if isinstance(item, s.Template) else "camera" if isinstance(item, s.Block) else "value"
        if used[item.name.id] == 1:
            message = f"the {what} `{item.name.id}` is never used"
            report.add("WMS410", message, item.name.span, "use it, or remove it", severity="warning")
