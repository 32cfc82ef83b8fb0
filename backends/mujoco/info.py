"""Metadata of MuJoCo, readable without importing it."""

from __future__ import annotations

from wmspec.sim.scene.backend import Graphics, Info
from wmspec.sim.scene.capability import (
    BALL_LIMITS,
    DOUBLE_PENDULUMS,
    FAST_SPINS,
    LEANING_CYLINDERS,
    TWO_FRICTIONS,
    Lack,
    fast_impacts,
    fine_drives,
    stiff_drives,
)
from wmspec.sim.scene.regime_thresholds import MAX_STEP_MULTIPLIER

STEPS_PER_SECOND = 3840
CONTACT_YIELD = 2.2e-3  # s: penetration per m/s of impact speed at this rate (see `.impact`)

INFO = Info(
    name="mujoco",
    title="MuJoCo",
    module="mujoco",
    distribution="mujoco",
    requirement="wmspec[mujoco]",
    steps_per_second=STEPS_PER_SECOND,
    lacks=(
        Lack(BALL_LIMITS, "MuJoCo has no such limits; remove the cone angles, or use hinges"),
        Lack(
            stiff_drives(MAX_STEP_MULTIPLIER * STEPS_PER_SECOND),
            "MuJoCo integrates drives explicitly and would overshoot; reduce the stiffness or increase the load",
        ),
        Lack(fine_drives(STEPS_PER_SECOND, damped=False), "MuJoCo uses up to 16 times as many steps", approximate=True),
        Lack(
            fast_impacts(CONTACT_YIELD, MAX_STEP_MULTIPLIER),
            f"contacts yield, even with {MAX_STEP_MULTIPLIER} times as many steps; slow the body down or thicken "
            "the obstacle",
            approximate=True,
        ),
        Lack(
            LEANING_CYLINDERS,
            "MuJoCo tips them above 0.85 of the angle, because few points support them; use boxes",
        ),
        Lack(FAST_SPINS, "MuJoCo integrates with first order if anything can collide, else with fourth"),
        Lack(
            DOUBLE_PENDULUMS,
            "MuJoCo integrates with first order: a few per cent are gained or lost",
        ),
        Lack(TWO_FRICTIONS, "MuJoCo has one coefficient; the dynamic one is used", approximate=True),
    ),
    drawing_cost=1.0,
    graphics=Graphics("EGL", mesa=(24, 3), variables=("MUJOCO_GL", "PYOPENGL_PLATFORM")),
)
