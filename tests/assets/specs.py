"""Specs with an asset, checked, staged and read back as the engines get them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.core.diagnostics import Report
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.statements.task import check
from wmspec.sim.scene.model import Array, Body, Scene
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.usd import read

HERE = Path(__file__).parent
CABINET = HERE.parents[1] / "docs/cabinet.urdf"
_TASK = """task t : custom {{
  {0}
  camera front {{ at: (0, -3 m, 1 m) }}
  observe front at [0 s, {1} s]
}}
"""


def checked(path: Path) -> tuple[TaskSpec | None, Report]:
    """The task in a spec and all that is wrong with it."""
    report = Report()
    specs = check(path, report)
    return (specs[0] if specs else None), report


def spec(body: str, folder: Path, seconds: float = 1.0) -> TaskSpec:
    """A task of some objects, in a folder where the assets are."""
    path = folder / "spec.wms"
    path.write_text(_TASK.format(body, seconds))
    found, report = checked(path)
    assert found is not None, [d.render() for d in report.diagnostics]
    return found


def here(tmp_path: Path) -> Path:
    """A folder with the assets of the tests in it."""
    for file in (CABINET, *(HERE / name for name in ("pendulum.urdf", "arm.urdf", "parts/wedge.obj"))):
        there = tmp_path / (file.relative_to(HERE) if file.is_relative_to(HERE) else file.name)
        there.parent.mkdir(exist_ok=True)
        there.write_bytes(file.read_bytes())
    return tmp_path


def scene(task: TaskSpec, index: int = 0) -> Scene:
    """What the engines get of an instance."""
    return read(compose(document(task, Design(task)[index])))


def named(found: Scene, name: str) -> Body:
    """A body by its name."""
    return next(body for body in found.bodies if body.name == name)


def tensor(body: Body) -> Array:
    """The inertia (3, 3) of a body about its centre of mass, in its own axes."""
    assert body.inertia is not None
    turn: Any = rotation(body.inertia.axes)
    return np.asarray(turn @ np.diag(body.inertia.moments) @ turn.T)
