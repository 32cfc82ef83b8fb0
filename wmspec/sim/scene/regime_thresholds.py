"""What is hard for engines, in numbers that rules on specs share with those on scenes; importing it costs nothing."""

from math import atan

BOUNCY = 0.2
"""Restitution of a pair from which on it matters which impact of a row comes first."""
STEEP = 0.7
"""Contacts steeper than this (cosine to the vertical) carry weight, and impacts go along the others; a cylinder whose
axis is steeper stands."""
FAST = 5.0
"""From which speed (m/s) on impacts are looked at: slower ones are executed as they always were."""
ENTERED = 0.5
"""The part of the thinnest body that another may enter: from its middle on it would be pushed out behind."""
FINEST = 16
"""How many times as many steps as usual are made for what is hard at most."""

LANDS, HEAVIER = 0.5, 5.0
"""From which speed (m/s) on, and how many times as heavy, things are looked at that land on what rests."""
TIPS = 0.85
"""From which part of the angle at which a cylinder tips on, some engines tip it."""
SWINGS = 3.0
"""How fast (rad/s) the two of a double pendulum turn against each other, or faster, when their energy is looked at."""
SPINS, KEPT = 30.0, 0.003
"""From which spin (rad/s) on, what turns on by itself is looked at, and by which part its energy may change."""
BALANCED = 1e-3
"""What turns about an axis this near to its centre of mass, in its radii of gyration, is a wheel and does not swing."""

ROOM = 1e-4
"""m: how far the capsule in a cylinder stays within its ends, where there is room."""


def leaning(radius: float, height: float, angle: float) -> bool:
    """Whether a cylinder (m) whose axis is turned so far (rad) from the vertical still stands, but only just."""
    tips = atan(2 * radius / height)
    return TIPS * tips < angle < tips


def disc(radius: float, height: float, *, stands: bool = False) -> bool:
    """Whether a cylinder (m) is shorter than it is thick: then no capsule fits into it for it to roll on.

    Into one that is as long as thick a ball fits, but on its end it would stand on the ball: not if it `stands`.
    """
    return height < 2 * radius * (1 - 1e-9) or (stands and height < 2 * radius + 2 * ROOM)
