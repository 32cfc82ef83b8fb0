"""The instance at the cursor, and its picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from wmspec.api.loading import TextCheck
from wmspec.api.task import Instance, Task
from wmspec.core.diagnostics import WmsError
from wmspec.editor import examples
from wmspec.editor.document import Document
from wmspec.lang.parse import syntax as s


@dataclass(frozen=True)
class Preview:
    """An instance: task, index, and factor levels in words."""

    task: str
    index: int
    factors: str

    def draw(self, text: str, path: Path) -> bytes:
        """Return a sheet (PNG) of its observed views, by the default engine. Runs in a separate process."""
        from wmspec.runtime.engines.registry import default

        examples.changed()  # a library may have changed
        return examples.picture(text, path, self.task, self.index, default(), 256)


def instance_at(document: Document, offset: int) -> Preview:
    """Return the instance at the cursor: the first of the task, with the factor level at the cursor, if any.

    Raises WmsError if the text has mistakes or no task.
    """
    check = TextCheck(document.text, document.path)
    diagnosis, tasks = check.diagnosis(tried=False), check.tasks
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
    """Return the neighbour of the first instance that has the factor level at an offset; None if there is none."""
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
