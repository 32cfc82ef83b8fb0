"""What PyBullet says of itself, without being imported."""

from __future__ import annotations

from wmspec.sim.scene.backend import Compiled, Info
from wmspec.sim.scene.capability import (
    BALL_LIMITS,
    DOUBLE_PENDULUMS,
    FAST_SPINS,
    MIMICS_APART,
    SEVERAL_MATERIALS,
    SLIDING_MESHES,
    TWO_FRICTIONS,
    Lack,
    damped_drives,
    fine_drives,
    friction_above,
    pieces_above,
    stiff_drives,
)
from wmspec.sim.scene.regime_thresholds import FINEST

STEPS_PER_SECOND = 1920
MOST_FRICTION = 10.0  # of a pair: Bullet's own limit
MOST_PIECES = 16  # of a moving body: PyBullet's own limit; all hulls are one

_OVERSHOOTS = "PyBullet computes drives step by step and would overshoot; make it softer or what it moves heavier"

INFO = Info(
    name="pybullet",
    title="PyBullet",
    module="pybullet",
    distribution="pybullet",
    requirement="wmspec[pybullet]",
    steps_per_second=STEPS_PER_SECOND,
    lacks=(
        Lack(BALL_LIMITS, "PyBullet has no such limits; remove the cone angles, or use hinges"),
        Lack(stiff_drives(FINEST * STEPS_PER_SECOND), _OVERSHOOTS),
        Lack(damped_drives(FINEST * STEPS_PER_SECOND), _OVERSHOOTS),
        Lack(fine_drives(STEPS_PER_SECOND), "PyBullet makes up to 16 times as many steps", nearly=True),
        Lack(
            SLIDING_MESHES,
            "Bullet keeps contacts where they no longer are: they stop 1 to 8 % early; use boxes or cylinders",
        ),
        Lack(FAST_SPINS, "Bullet integrates to first order, gyroscopes on joints explicitly"),
        Lack(
            DOUBLE_PENDULUMS,
            "Bullet integrates to first order: a few per cent come and go",
        ),
        Lack(TWO_FRICTIONS, "PyBullet has one coefficient, that of motion", nearly=True),
        Lack(MIMICS_APART, "PyBullet's gears are of one multibody; join the two by a joint"),
        Lack(
            SEVERAL_MATERIALS,
            "PyBullet has one material a moving body; give its pieces the same friction and restitution",
        ),
        Lack(
            pieces_above(MOST_PIECES),
            f"PyBullet takes {MOST_PIECES} pieces of a moving body, all hulls together counting as one; use fewer, "
            "or meshes",
        ),
        Lack(friction_above(MOST_FRICTION), f"Bullet's own limit is {MOST_FRICTION:g}; lower the friction"),
    ),
    # Without NumPy in sight its pictures come back as tuples, which takes longer. GCC 14 takes its pointers for errors.
    compiled=Compiled(
        wheels_until=(3, 11), needs=("setuptools>=70.1",), variables="CFLAGS=-Wno-incompatible-pointer-types"
    ),
)
