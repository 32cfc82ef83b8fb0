"""Which instance the cursor points at, and a picture of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from wmspec.api.loading import diagnose_text
from wmspec.api.task import Instance, Task
from wmspec.core.diagnostics import WmsError
from wmspec.editor import examples
from wmspec.editor.document import Document
from wmspec.lang.parse import syntax as s


@dataclass(frozen=True)
class Preview:
    """An instance: its task, its index, the values of its factors in words."""

    task: str
    index: int
    factors: str

    def draw(self, text: str, path: Path) -> bytes:
        """A sheet (PNG) of what is observed of it, by the first engine that there is. For a process of its own."""
        from wmspec.runtime.engines.registry import default

        examples.changed()  # a library may have changed
        return examples.picture(text, path, self.task, self.index, default(), 256)


def pointed_at(document: Document, offset: int) -> Preview:
    """The instance under the cursor: the first of the task there, with the value of a factor if one is there.

    Raises WmsError if the text has mistakes or no task.
    """
    diagnosis, tasks = diagnose_text(document.text, document.path, tried=False)
    if not diagnosis.passed:
        raise WmsError.of(d for d in diagnosis.diagnostics if d.severity == "error")
    if not tasks:
        raise WmsError("there is no task here; a library has nothing to draw")
    around, variant = document.around(offset)
    name = "_".join(part.name.id for part in (around, variant) if part is not None)
    task = next((t for t in tasks if t.name == name), tasks[0])
    instance = _with_value(task, document, offset) or task[0]
    return Preview(task.name, instance.index, str(instance))


def _with_value(task: Task, document: Document, offset: int) -> Instance | None:
    """An instance that has the value of a factor at an offset, and is otherwise as the first."""
    path = document.nodes_at(offset)
    factor = next((n for n in path if isinstance(n, s.Factor) and not n.nuisance), None)
    if factor is None or not isinstance(factor.domain, s.Items):
        return None
    number = next((i for i, e in enumerate(factor.domain.items) if e.span.start <= offset <= e.span.end), None)
    declared = next((f for f in task.factors if f.name == factor.name.id), None)
    if number is None or declared is None or declared.values is None or number >= len(declared.values):
        return None
    value, first = declared.values[number], task[0]
    candidates = (first, *first.neighbors(declared.name))
    return next((i for i in candidates if i.factors[declared.name] == value), None)
