"""Metadata of SAPIEN, readable without importing it."""

from __future__ import annotations

from wmspec.sim.scene.backend import Graphics, Info
from wmspec.sim.scene.capability import (
    BALL_LIMITS,
    DOUBLE_PENDULUMS,
    FAST_SPINS,
    HEAVY_LANDINGS,
    LEANING_CYLINDERS,
    MIMICS_APART,
    MIMICS_PAST,
    ROLLING_CYLINDERS,
    TOUCHING_NEIGHBOURS,
    TWO_FRICTIONS,
    Lack,
)

INFO = Info(
    name="sapien",
    title="SAPIEN",
    module="sapien",
    distribution="sapien",
    requirement="wmspec[sapien]",
    steps_per_second=1920,
    lacks=(
        # measured: SAPIEN accepts cone limits, but joints exceed them
        Lack(BALL_LIMITS, "SAPIEN does not enforce such limits; remove the cone angles, or use hinges"),
        Lack(ROLLING_CYLINDERS, "PhysX rolls prisms, which brake; use height of at least the diameter, or spheres"),
        Lack(
            LEANING_CYLINDERS,
            "PhysX tips them above 0.85 of the angle, because few points support them; use boxes",
        ),
        Lack(
            HEAVY_LANDINGS,
            "PhysX lets it rebound above 5 times the mass, or above equal mass if it does not start above",
        ),
        Lack(FAST_SPINS, "PhysX integrates with first order"),
        Lack(
            DOUBLE_PENDULUMS,
            "PhysX integrates with first order: a few per cent are gained or lost",
        ),
        # measured: with PhysX's static coefficient, a box slips on a slope that should hold it
        Lack(TWO_FRICTIONS, "a body that starts to creep in PhysX gets the dynamic coefficient", approximate=True),
        Lack(MIMICS_APART, "PhysX's tendons work within one articulation; join the two"),
        Lack(
            MIMICS_PAST,
            "PhysX's tendons pass hinges and sliders only; remove the mimic, or merge fixed bodies",
        ),
        Lack(
            TOUCHING_NEIGHBOURS,
            "PhysX does not collide the two bodies of a joint; author physics:collisionEnabled = 0",
        ),
    ),
    drawing_cost=2.0,  # see benchmarks/render.py
    # measured: SAPIEN 3.0.3 finds no device on Mesa 22.3 and draws on 24.3
    graphics=Graphics("Vulkan", mesa=(24, 3), variables=("VK_DRIVER_FILES", "VK_ICD_FILENAMES")),
)
