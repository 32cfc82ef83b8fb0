"""Templates of first specs: valid specs whose task is renamed."""

from __future__ import annotations

import re
from importlib.resources import files

from wmspec.core.diagnostics import Report, WmsError, suggestion
from wmspec.core.places import Source
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.parser import parse

SUFFIX = ".wms"


def templates() -> dict[str, str]:
    """Return the text of each template by name."""
    folder = files("wmspec.editor") / "templates"
    texts = {entry.name: entry.read_text(encoding="utf-8") for entry in folder.iterdir() if entry.name.endswith(SUFFIX)}
    return {name.removesuffix(SUFFIX): texts[name] for name in sorted(texts)}


def template_titles() -> dict[str, str]:
    """Return a line about each template."""
    return {name: text.splitlines()[0].strip('"') for name, text in templates().items()}


def first_spec(name: str, template: str) -> str:
    """Return the text of a first spec with a task `name`. Raises WmsError for an invalid name or template."""
    known = templates()
    if template not in known:
        raise WmsError(f"there is no template `{template}`; {suggestion(template, known)}")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        better = re.sub(r"\W+", "_", name).strip("_") or "my_task"
        better = f"task_{better}" if better[0].isdigit() else better
        raise WmsError(
            f"`{name}` is not a name: names are letters, digits and `_`, and do not begin with a digit; try `{better}`"
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
