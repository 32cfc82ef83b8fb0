"""First specs: templates that are specs themselves, with another name for their task."""

from __future__ import annotations

import re
from importlib.resources import files

from wmspec.core.diagnostics import Report, WmsError, suggestion
from wmspec.core.places import Source
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.parser import parse

SUFFIX = ".wms"


def templates() -> dict[str, str]:
    """The templates by name, each with its text."""
    folder = files("wmspec.editor") / "templates"
    texts = {entry.name: entry.read_text(encoding="utf-8") for entry in folder.iterdir() if entry.name.endswith(SUFFIX)}
    return {name.removesuffix(SUFFIX): texts[name] for name in sorted(texts)}


def about() -> dict[str, str]:
    """What each template is about, in a line."""
    return {name: text.splitlines()[0].strip('"') for name, text in templates().items()}


def first_spec(name: str, template: str) -> str:
    """The text of a first spec whose task is called `name`. Raises WmsError for a name or template that cannot be."""
    known = templates()
    if template not in known:
        raise WmsError(f"there is no template `{template}`; {suggestion(template, known)}")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        better = re.sub(r"\W+", "_", name).strip("_") or "my_task"
        better = f"task_{better}" if better[0].isdigit() else better
        raise WmsError(
            f"`{name}` is no name: names are letters, digits and `_`, and begin with no digit; try `{better}`"
        )
    text = _named(known[template], name)
    report = Report()
    parse(Source(f"{name}{SUFFIX}", text), report)
    if report.failed:
        raise WmsError(f"`{name}` is a word of the language; choose another name")
    return text


def _named(text: str, name: str) -> str:
    file = parse(Source("template", text), Report())
    (task,) = (item for item in file.items if isinstance(item, s.Task))
    return text[: task.name.span.start] + name + text[task.name.span.end :]
