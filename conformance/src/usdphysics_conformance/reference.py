"""Sources, and answers that no elementary function gives."""

from __future__ import annotations

from math import pi, sqrt

MECHANICS = "Meriam and Kraige, Engineering Mechanics: Dynamics"
LANDAU = "Landau and Lifshitz, Mechanics, § 37"

DZHANIBEKOV_TIME = 1.8751692117201915
"""When (s) the body of the case `dzhanibekov` has turned its middle axis by a right angle.

Euler's equations, integrated by a Runge-Kutta method of order 5 with a relative tolerance of 1e-11. The tests integrate
them again.
"""

DOUBLE_PENDULUM_END = (-0.5102697085563247, 0.0, -0.00855772557206591)
"""Where (m) the centre of the lower arm of the case `double_pendulum` is after 1 s.

Lagrange's equations, integrated by a Runge-Kutta method of order 8 with a relative tolerance of 1e-11. The tests
integrate them again.
"""


def elliptic_k(m: float) -> float:
    """The complete elliptic integral of the first kind K(m), 0 <= m < 1, by the arithmetic-geometric mean."""
    a, b = 1.0, sqrt(1.0 - m)
    while abs(a - b) > 4e-16 * a:
        a, b = (a + b) / 2, sqrt(a * b)
    return pi / (a + b)
