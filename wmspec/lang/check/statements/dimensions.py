"""Known dimensions of the catalogue's tasks, to detect misspelled ones."""

from __future__ import annotations

from collections.abc import Sequence

from wmspec.core.diagnostics import Remedy, Report
from wmspec.core.spelling import edit_distance
from wmspec.lang.parse import syntax as s

#: Continuations of every path. A test verifies that all specs of the catalogue are included.
DIMENSIONS: dict[str, str] = {
    "": "perception prediction custom",
    "perception": "motion physics quantity space time vision",
    "perception.motion": "direction identification presence speed trajectory",
    "perception.physics": "friction mass",
    "perception.quantity": "conjunction continuous discrete relative",
    "perception.space": "occupancy perspective positioning relation rotation size vacancy",
    "perception.time": "extension positioning",
    "perception.vision": "color material shape",
    "prediction": "compositionality mechanistic transitivity",
    "prediction.compositionality": "collision manipulation physics",
    "prediction.mechanistic": (
        "aim chain collision containment flight hinge impact joint manipulation navigation occlusion permanence "
        "physics roll rolling stability support swing torque"
    ),
    "prediction.transitivity": "manipulation navigation",
}


def warn_near_known(path: Sequence[s.Name], report: Report) -> None:
    """Warn about a dimension one edit away from a known one."""
    for i, name in enumerate(path):
        known = DIMENSIONS.get(".".join(n.id for n in path[:i]), "").split()
        near = next((other for other in known if edit_distance(name.id.lower(), other, 2) < 2), None)
        if name.id in known or near is None:
            continue
        remedy = Remedy.of(f"did you mean `{near}`?", name.id, near)
        report.add("WMS201", f"`{name.id}` is a new dimension, close to a known one", name.span, remedy, (), "warning")
        return
