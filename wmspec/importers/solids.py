"""Volume and inertia of solid shapes, as in any table; a capsule is a cylinder and two half balls."""

from __future__ import annotations

from math import pi

import numpy as np

from wmspec.importers.model import Array, Shape


def volume(shape: Shape) -> float:
    """How much room (m³) a box, sphere, cylinder or capsule takes."""
    match shape.kind:
        case "box":
            return float(np.prod(shape.size))
        case "sphere":
            return 4 / 3 * pi * shape.size[0] ** 3
        case "cylinder":
            return pi * shape.size[0] ** 2 * shape.size[1]
    radius, height = shape.size
    return pi * radius**2 * (height - 2 * radius) + 4 / 3 * pi * radius**3


def inertia(shape: Shape) -> Array:
    """The tensor of inertia (3, 3) of 1 kg of it about its middle, along its own axes, m²."""
    match shape.kind:
        case "box":
            x, y, z = (edge**2 / 12 for edge in shape.size)
            return np.diag((y + z, x + z, x + y))
        case "sphere":
            return np.eye(3) * (0.4 * shape.size[0] ** 2)
        case "cylinder":
            radius, height = shape.size
            across = radius**2 / 4 + height**2 / 12
            return np.diag((across, across, radius**2 / 2))
    radius, height = shape.size
    straight = height - 2 * radius
    tube, balls = pi * radius**2 * straight, 4 / 3 * pi * radius**3
    along = tube * radius**2 / 2 + balls * 0.4 * radius**2
    across = tube * (radius**2 / 4 + straight**2 / 12)
    across += balls * (0.4 * radius**2 + straight**2 / 4 + 3 / 8 * radius * straight)
    return np.diag((across, across, along)) / (tube + balls)
