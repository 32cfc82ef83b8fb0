"""The function of a verb: `hop` sends an object straight up, to a given height."""

from __future__ import annotations

import math

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.document import Prim
from wmspec.lang.check.ir.ir import Entity


def hop(prim: Prim, action: Entity, values: Evaluator) -> None:
    """To rise by h, an object starts at the speed sqrt(2 g h)."""
    name = action.name
    speed = math.sqrt(2 * values.gravity * values.number(name, "height"))
    prim.set("wms:speed", "double", speed, f"{name}.height", "world.gravity", uniform=True)
    prim.set("wms:direction", "double3", (0.0, 0.0, 1.0), uniform=True)
    prim.set("wms:spin", "double3", (0.0, 0.0, 0.0), uniform=True)
