"""Metadata of Newton, readable without importing it. Step rate, contacts and lacks are those of the MuJoCo backend."""

from __future__ import annotations

from dataclasses import replace

from wmspec.backends.mujoco.info import INFO as MUJOCO
from wmspec.sim.scene.backend import Info
from wmspec.sim.scene.capability import FAST_SPINS

_REASONS = {FAST_SPINS: "Newton integrates with first order"}

INFO = Info(
    name="newton",
    title="Newton",
    module="newton",
    distribution="newton",
    requirement="wmspec-newton",
    steps_per_second=MUJOCO.steps_per_second,
    draws=False,
    lacks=tuple(
        replace(lack, reason=_REASONS.get(lack.capability, lack.reason.replace("MuJoCo", "Newton")))
        for lack in MUJOCO.lacks
    ),
)
