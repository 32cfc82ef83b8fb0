"""Thresholds of regimes in which engines differ, shared by rules on specs and on scenes. Imports are cheap."""

from math import atan

ELASTIC_RESTITUTION = 0.2
"""Restitution of a pair above which the order of simultaneous impacts matters."""
STEEP_COSINE = 0.7
"""Cosine to the vertical. Steeper contact normals carry weight, others transmit impacts. A cylinder with a steeper
axis stands."""
FAST_IMPACT = 5.0
"""Speed (m/s) above which impacts are refined."""
MAX_ENTERED_FRACTION = 0.5
"""Fraction of the thinnest body that another may enter; beyond the middle it is ejected on the far side."""
MAX_STEP_MULTIPLIER = 16
"""Largest factor by which the step rate is increased."""
MAX_STEP_RESPONSE = 0.5
"""Largest response of a drive per engine step: oscillation (rad per step)², decay as a fraction."""
COARSEST_STEP_RATE = 1920
"""Step rate (Hz) of the coarsest engine with explicit drives, before it is increased."""

HEAVY_LANDING_SPEED, HEAVY_LANDING_RATIO = 0.5, 5.0
"""Speed (m/s) and mass ratio above which landings on a resting body are flagged."""
TIPPING_FRACTION = 0.85
"""Fraction of the tipping angle above which some engines tip a cylinder."""
FAST_DOUBLE_PENDULUM = 3.0
"""Relative angular speed (rad/s) above which the energy of a double pendulum is checked."""
FAST_SPIN, MAX_ENERGY_CHANGE = 30.0, 0.003
"""Angular speed (rad/s) above which free rotation is checked, and its allowed relative change of energy."""
WHEEL_OFFSET = 1e-3
"""Distance of axis and centre of mass, in radii of gyration, below which a body is a wheel and not a pendulum."""

CAPSULE_CLEARANCE = 1e-4
"""m: clearance between the inscribed capsule of a cylinder and its ends."""


def is_leaning(radius: float, height: float, angle: float) -> bool:
    """Whether a cylinder (m) tilted by `angle` (rad) still stands, close to tipping."""
    tips = atan(2 * radius / height)
    return TIPPING_FRACTION * tips < angle < tips


def is_disc(radius: float, height: float, *, stands: bool = False) -> bool:
    """Whether a cylinder (m) is too short to contain a capsule to roll on.

    A cylinder as long as wide contains a ball, but must not stand on it if it `stands`.
    """
    return height < 2 * radius * (1 - 1e-9) or (stands and height < 2 * radius + 2 * CAPSULE_CLEARANCE)
