"""What begins in the air above something that moves is found; what rests on it, is beside it or bounces is not."""

from __future__ import annotations

import pytest
from pxr import Usd

from usdphysics_conformance.stages import body, box, floor, joint, stage
from wmspec.sim.scene.physics.initial_drops import initial_drops
from wmspec.sim.usd import read

CUBE = box(0.2, 0.2, 0.2)
BELOW = body("below", CUBE, (0, 0, 0.1))
HIGH = body("high", CUBE, (0.1, 0, 0.9))


@pytest.mark.parametrize(
    ("prims", "material", "found"),
    [
        ((BELOW, HIGH), {}, {(2, 1)}),
        ((BELOW, HIGH), {"restitution": 0.3}, set()),
        ((BELOW, HIGH), {"gravity": 0.0}, set()),
        ((BELOW, body("high", CUBE, (0.3, 0, 0.9))), {}, set()),
        ((BELOW, body("high", CUBE, (0, 0, 0.3))), {}, set()),
        ((BELOW, body("mid", CUBE, (0, 0, 0.3)), body("high", CUBE, (0, 0, 0.5))), {}, set()),
        ((BELOW, body("mid", CUBE, (0, 0, 0.3)), HIGH), {}, {(3, 1), (3, 2)}),
        ((BELOW, HIGH, body("shelf", box(1, 1, 0.1), (0, 0, 0.75), mass=None)), {}, set()),
        ((BELOW, HIGH, joint("Fixed", "j", "", "high", (0.1, 0, 0.9))), {}, set()),
    ],
)
def test_initial_drops_are_found(
    prims: tuple[str, ...], material: dict[str, float], found: set[tuple[int, int]]
) -> None:
    made = Usd.Stage.CreateInMemory()
    made.GetRootLayer().ImportFromString(stage(floor(), *prims, **material))
    assert initial_drops(read(made, strict=False)) == found
