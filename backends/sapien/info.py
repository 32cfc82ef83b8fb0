"""What SAPIEN says of itself, without being imported."""

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
        # Measured: SAPIEN's drives take cone limits, and let joints pass them.
        Lack(BALL_LIMITS, "SAPIEN lets joints pass such limits; remove the cone angles, or use hinges"),
        Lack(
            ROLLING_CYLINDERS, "PhysX rolls polygons, which brake; make them as long as they are thick, or use spheres"
        ),
        Lack(
            LEANING_CYLINDERS,
            "PhysX tips them from 0.85 of the angle on, as it carries them on few points; use boxes",
        ),
        Lack(
            HEAVY_LANDINGS,
            "PhysX lets it rise again, from 5 times the mass on; or from the same on, if it does not begin above it",
        ),
        Lack(FAST_SPINS, "PhysX integrates to first order"),
        Lack(
            DOUBLE_PENDULUMS,
            "PhysX integrates to first order: a few per cent come and go",
        ),
        # Measured: with PhysX's coefficient at rest too, a box slips on a slope that only this one would hold it on.
        Lack(TWO_FRICTIONS, "what begins to creep in PhysX has the coefficient of motion from then on", nearly=True),
        Lack(MIMICS_APART, "PhysX's tendons are of one articulation; join the two by a joint"),
        Lack(
            MIMICS_PAST,
            "PhysX's tendons pass hinges and sliders alone; remove the mimic, or make one body of what is fixed",
        ),
        Lack(
            TOUCHING_NEIGHBOURS,
            "PhysX lets the two bodies of a joint pass through each other; author physics:collisionEnabled = 0",
        ),
    ),
    # Measured: SAPIEN 3.0.3 finds no device on Mesa 22.3, and draws from 24.3 on.
    graphics=Graphics("Vulkan", mesa=(24, 3), variables=("VK_DRIVER_FILES", "VK_ICD_FILENAMES")),
)
