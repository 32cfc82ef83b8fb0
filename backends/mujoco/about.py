"""What MuJoCo says of itself, without being imported."""

from __future__ import annotations

from wmspec.scene.backend import Graphics, Info
from wmspec.scene.capability import BALL_LIMITS, Lack, stiff_drives

STEPS_PER_SECOND = 3840

INFO = Info(
    name="mujoco",
    title="MuJoCo",
    module="mujoco",
    distribution="mujoco",
    requirement="wmspec[mujoco]",
    steps_per_second=STEPS_PER_SECOND,
    looks=("parity", "beauty"),
    lacks=(
        Lack(BALL_LIMITS, "MuJoCo has no such limits; remove the cone angles, or use hinges"),
        Lack(
            stiff_drives(STEPS_PER_SECOND),
            "MuJoCo computes drives step by step and would overshoot; make it softer or what it moves heavier",
        ),
    ),
    graphics=Graphics("EGL", mesa=(24, 3), variables=("MUJOCO_GL", "PYOPENGL_PLATFORM"), on_import=True),
)
