"""The Franka Emika Panda with its hand: parameters of `panda.urdf` (franka_description, Apache-2.0)."""

from __future__ import annotations

from math import pi

import numpy as np

from wmspec.compile.robots.arm import Arm, axis_rotation, translation

_ROLLS = (0.0, -pi / 2, pi / 2, pi / 2, -pi / 2, pi / 2, pi / 2)
_PLACES = (
    (0.0, 0.0, 0.333),
    (0.0, 0.0, 0.0),
    (0.0, -0.316, 0.0),
    (0.0825, 0.0, 0.0),
    (-0.0825, 0.384, 0.0),
    (0.0, 0.0, 0.0),
    (0.088, 0.0, 0.0),
)

PANDA = Arm(
    frames=np.array(
        [translation(*place) @ axis_rotation(0, roll) for place, roll in zip(_PLACES, _ROLLS, strict=True)]
    ),
    hand=translation(0.0, 0.0, 0.107) @ axis_rotation(2, -pi / 4),
    reach=0.1034,
    finger=0.0584,
    low=np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]),
    high=np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]),
    speed=np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61]),
    home=np.array([0.0, pi / 8, 0.0, -pi * 5 / 8, 0.0, pi * 3 / 4, pi / 4]),
    rest=np.array([0.0, -0.769825, 0.0, -2.569866, 0.0, 1.80004, 0.785398]),
    hull=np.array([[-0.032, -0.104, -0.026], [0.032, 0.101, 0.066]]),
    tip=np.array([[-0.011, 0.0, 0.0], [0.011, 0.022, 0.0545]]),
    opening=0.08,
    palm=0.037,
    pad=0.008,
    width=0.021,
    grip=70.0,
    rubber=1.0,
    asset="compile/robots/panda/panda.usdc",
    joints=(*(f"joint{i}" for i in range(1, 8)), "left_slide", "right_slide"),
)
