"""Metadata of Newton, readable without importing it. Step rate and contacts are those of the MuJoCo backend."""

from __future__ import annotations

from wmspec.backends.mujoco.info import CONTACT_YIELD, STEPS_PER_SECOND
from wmspec.sim.scene.backend import Info
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

INFO = Info(
    name="newton",
    title="Newton",
    module="newton",
    distribution="newton",
    requirement="wmspec-newton",
    steps_per_second=STEPS_PER_SECOND,
    draws=False,
    lacks=(
        Lack(BALL_LIMITS, "Newton has no such limits; remove the cone angles, or use hinges"),
        Lack(
            stiff_drives(MAX_STEP_MULTIPLIER * STEPS_PER_SECOND),
            "Newton integrates drives explicitly and would overshoot; reduce the stiffness or increase the load",
        ),
        Lack(fine_drives(STEPS_PER_SECOND, damped=False), "Newton uses up to 16 times as many steps", approximate=True),
        Lack(
            fast_impacts(CONTACT_YIELD, MAX_STEP_MULTIPLIER),
            f"contacts yield, even with {MAX_STEP_MULTIPLIER} times as many steps; slow the body down or thicken "
            "the obstacle",
            approximate=True,
        ),
        Lack(LEANING_CYLINDERS, "Newton tips them above 0.85 of the angle, because few points support them; use boxes"),
        Lack(FAST_SPINS, "Newton integrates with first order"),
        Lack(DOUBLE_PENDULUMS, "Newton integrates with first order: a few per cent are gained or lost"),
        Lack(TWO_FRICTIONS, "Newton has one coefficient; the dynamic one is used", approximate=True),
    ),
)
