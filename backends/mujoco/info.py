"""What MuJoCo says of itself, without being imported."""

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
from wmspec.sim.scene.regime_thresholds import FINEST

STEPS_PER_SECOND = 3840
GIVES = 2.2e-3  # s: how far a contact gives way for each m/s of an impact, at this rate; see `.impact`

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
            stiff_drives(FINEST * STEPS_PER_SECOND),
            "MuJoCo computes drives step by step and would overshoot; make it softer or what it moves heavier",
        ),
        Lack(fine_drives(STEPS_PER_SECOND), "MuJoCo makes up to 16 times as many steps", nearly=True),
        Lack(
            fast_impacts(GIVES, FINEST),
            f"MuJoCo's contacts give way, even with {FINEST} times as many steps; make it slower, or what it may hit "
            "thicker",
            nearly=True,
        ),
        Lack(
            LEANING_CYLINDERS,
            "MuJoCo tips them from 0.85 of the angle on, as it carries them on few points; use boxes",
        ),
        Lack(FAST_SPINS, "MuJoCo integrates to first order where anything can be touched, else to fourth"),
        Lack(
            DOUBLE_PENDULUMS,
            "MuJoCo integrates to first order: a few per cent come and go",
        ),
        Lack(TWO_FRICTIONS, "MuJoCo has one coefficient, that of motion", nearly=True),
    ),
    graphics=Graphics("EGL", mesa=(24, 3), variables=("MUJOCO_GL", "PYOPENGL_PLATFORM"), on_import=True),
)
