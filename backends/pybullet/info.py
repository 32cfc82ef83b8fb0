"""Metadata of PyBullet, readable without importing it."""

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
    armatures_above,
    armatures_below,
    damped_drives,
    fine_drives,
    friction_above,
    pieces_above,
    stiff_drives,
)
from wmspec.sim.scene.regime_thresholds import COARSEST_STEP_RATE, MAX_STEP_MULTIPLIER

STEPS_PER_SECOND = COARSEST_STEP_RATE
LEAST_ARMATURE = 0.01  # of the inertia that a joint moves: below, leaving it out changes little
MAX_FRICTION = 10.0  # per pair: Bullet's limit
MAX_PIECES = 16  # per moving body: PyBullet's limit; all hulls count as one

_OVERSHOOTS = "PyBullet integrates drives explicitly and would overshoot; reduce the stiffness or increase the load"

INFO = Info(
    name="pybullet",
    title="PyBullet",
    module="pybullet",
    distribution="pybullet",
    requirement="wmspec[pybullet]",
    steps_per_second=STEPS_PER_SECOND,
    lacks=(
        Lack(armatures_above(LEAST_ARMATURE), "PyBullet has none; use another engine, or set it to 0"),
        Lack(armatures_below(LEAST_ARMATURE), "PyBullet has none; it is left out", approximate=True),
        Lack(BALL_LIMITS, "PyBullet has no such limits; remove the cone angles, or use hinges"),
        Lack(stiff_drives(MAX_STEP_MULTIPLIER * STEPS_PER_SECOND), _OVERSHOOTS),
        Lack(damped_drives(MAX_STEP_MULTIPLIER * STEPS_PER_SECOND), _OVERSHOOTS),
        Lack(fine_drives(STEPS_PER_SECOND), "PyBullet uses up to 16 times as many steps", approximate=True),
        Lack(
            SLIDING_MESHES,
            "Bullet keeps stale contacts: they stop 1 to 8 % early; use boxes or cylinders",
        ),
        Lack(FAST_SPINS, "Bullet integrates with first order, gyroscopic joints explicitly"),
        Lack(
            DOUBLE_PENDULUMS,
            "Bullet integrates with first order: a few per cent are gained or lost",
        ),
        Lack(TWO_FRICTIONS, "PyBullet has one coefficient; the dynamic one is used", approximate=True),
        Lack(MIMICS_APART, "PyBullet's gears work within one multibody; join the two"),
        Lack(
            SEVERAL_MATERIALS,
            "PyBullet has one material per moving body; use equal friction and restitution",
        ),
        Lack(
            pieces_above(MAX_PIECES),
            f"PyBullet takes {MAX_PIECES} pieces of a moving body, all hulls together counting as one; use fewer, "
            "or meshes",
        ),
        Lack(friction_above(MAX_FRICTION), f"Bullet's own limit is {MAX_FRICTION:g}; lower the friction"),
    ),
    drawing_cost=3.0,  # see benchmarks/render.py
    # without NumPy at build time pictures are slow tuples; GCC 14 rejects its pointer casts
    compiled=Compiled(
        wheels_until=(3, 11), needs=("setuptools>=70.1",), variables="CFLAGS=-Wno-incompatible-pointer-types"
    ),
)
