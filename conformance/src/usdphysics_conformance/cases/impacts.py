"""Impacts of balls, rows of balls and dominoes; pushers and conveyors; filtered collisions."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, sqrt

import numpy as np

from usdphysics_conformance.case import Case, Criterion, Trace, make_case
from usdphysics_conformance.reference import MECHANICS
from usdphysics_conformance.stages import G, ball, body, box, cylinder, floor, joint, stage

_RADIUS = 0.05


def build_cases() -> Iterator[Case]:
    """The cases."""
    yield from _pairs()
    yield from _cradles()
    yield from _rows()
    yield from _driven()
    yield from _filtered()


def _pairs() -> Iterator[Case]:
    for name, m, n, e in (("equal", 1.0, 1.0, 1.0), ("unequal", 1.0, 3.0, 0.5), ("inelastic", 2.0, 1.0, 0.0)):
        v = 1.0
        first, second = v * (m - e * n) / (m + n), v * (1 + e) * m / (m + n)
        yield make_case(
            f"collide_{name}",
            stage(
                body("striker", ball(_RADIUS), (-0.2037, 0, 0), mass=m, velocity=(v, 0, 0)),
                body("struck", ball(_RADIUS), mass=n),
                friction=0,
                restitution=e,
                gravity=0,
            ),
            0.5,
            *(
                Criterion(
                    f"speed of the {label} ball",
                    answer,
                    0.015,
                    "m/s",
                    lambda r, which=which: r[which].linear_velocity[120, 0],  # type: ignore[misc]
                    "v (m − e n)/(m + n), v (1 + e) m/(m + n)",
                    MECHANICS,
                )
                for which, label, answer in (("striker", "striking", first), ("struck", "struck", second))
            ),
        )
    b = _RADIUS  # the impact parameter: half a diameter, which is an angle of 30 degrees
    yield make_case(
        "collide_oblique",
        stage(
            body("striker", ball(_RADIUS), (-0.3037, b, 0), velocity=(1.0, 0, 0)),
            body("struck", ball(_RADIUS)),
            friction=0,
            restitution=1.0,
            gravity=0,
        ),
        0.6,
        Criterion(
            "speed of the struck ball",
            sqrt(3) / 2,
            0.015,
            "m/s",
            lambda r: r["struck"].speed(0.6),
            "v cos θ",
            MECHANICS,
        ),
        Criterion(
            "speed of the striking ball", 0.5, 0.015, "m/s", lambda r: r["striker"].speed(0.6), "v sin θ", MECHANICS
        ),
        Criterion(
            "angle between the velocities of both balls",
            90.0,
            1.0,
            "deg",
            lambda r: degrees(
                np.arccos(
                    r["struck"].linear_velocity[144]
                    @ r["striker"].linear_velocity[144]
                    / (r["struck"].speed(0.6) * r["striker"].speed(0.6))
                )
            ),
            "90°, of equal masses and e = 1",
            MECHANICS,
        ),
    )
    yield make_case(
        "density",
        stage(
            body(
                "striker",
                ball(_RADIUS),
                (-0.2037, 0, 0),
                mass=0.0,
                velocity=(1.0, 0, 0),
                attributes=_DENSITY.format(2000),
            ),
            body("struck", ball(_RADIUS), mass=0.0, attributes=_DENSITY.format(1000)),
            friction=0,
            restitution=1.0,
            gravity=0,
        ),
        0.5,
        Criterion(
            "speed of the struck ball, which has half the density",
            4 / 3,
            0.02,
            "m/s",
            lambda r: r["struck"].linear_velocity[120, 0],
            "2 v m/(m + n)",
            MECHANICS,
        ),
    )


_DENSITY = "        float physics:density = {}\n"


def _cradles() -> Iterator[Case]:
    for name, gap, striking in (("touching", 0.0, 1), ("gapped", 0.002, 1), ("two_gapped", 0.002, 2)):
        balls = [
            body(
                f"ball{i}",
                ball(_RADIUS),
                ((2 * _RADIUS + gap) * i - (0.1013 if i < striking else 0.0), 0, 0),
                velocity=(1.0 if i < striking else 0.0, 0, 0),
            )
            for i in range(5)
        ]
        yield make_case(
            f"cradle_{name}",
            stage(*balls, friction=0, restitution=1.0, gravity=0),
            0.5,
            *(
                Criterion(
                    f"speed of ball {i} in a row of five",
                    1.0 if i >= 5 - striking else 0.0,
                    0.03,
                    "m/s",
                    lambda r, i=i: r[f"ball{i}"].linear_velocity[120, 0],  # type: ignore[misc]
                    "as many leave as came, by one impact after the other",
                    "Herrmann and Schmälzle, American Journal of Physics 49 (1981)",
                )
                for i in range(5)
            ),
        )


def _rows() -> Iterator[Case]:
    bricks = [body(f"brick{i}", box(0.02, 0.08, 0.16), (0.06 * i, 0, 0.08), mass=0.2) for i in range(6)]
    hit = body("ball", ball(0.03), (-0.11, 0, 0.14), mass=0.5, velocity=(1.0, 0, 0))
    yield make_case(
        "domino",
        stage(floor(), *bricks, hit),
        2.0,
        Criterion(
            "number of dominoes that fall, of six",
            6,
            0,
            "",
            lambda r: sum(r[f"brick{i}"].axis_direction(2.0, 2)[2] < 0.7 for i in range(6)),
            "all, as each is hit above its middle by one that falls",
            MECHANICS,
        ),
    )


def _driven() -> Iterator[Case]:
    """A heavy body on a rail with a strong drive, which is how UsdPhysics prescribes a motion."""
    v, mu = 0.5, 0.4
    drive = f"damping = 50000\ntargetVelocity = {v}\nstiffness = 0\nmaxForce = inf"
    slid = v * v / (2 * mu * G)
    plate = body("plate", box(6.0, 1.0, 0.1), (1.0, 0, 0.95), mass=100.0)
    box_on = body("box", box(0.2, 0.2, 0.1), (0, 0, 1.05), mass=1.0)
    yield make_case(
        "conveyor",
        stage(
            plate, box_on, joint("Prismatic", "rail", "", "plate", (1.0, 0, 0.95), axis="X", drive=drive), friction=mu
        ),
        1.0,
        Criterion(
            "speed of a box on the conveyor", v, 0.01, "m/s", lambda r: r["box"].linear_velocity[240, 0], "v", MECHANICS
        ),
        Criterion(
            "distance by which the box lags behind the conveyor",
            slid,
            0.004,
            "m",
            lambda r: _distance(r, "plate") - _distance(r, "box"),
            "v²/2μg",
            MECHANICS,
        ),
    )
    pusher = body("pusher", box(0.1, 1.0, 0.1), (-0.4, 0, 0.1), mass=100.0)
    pushed = body("box", box(0.2, 0.2, 0.1), (0, 0, 0.05), mass=1.0)
    yield make_case(
        "pusher",
        stage(
            floor(),
            pusher,
            pushed,
            joint("Prismatic", "rail", "", "pusher", (-0.4, 0, 0.1), axis="X", limits=(-1.0, 1.0), drive=drive),
            friction=mu,
        ),
        1.5,
        Criterion(
            "position of a pushed box after 1.5 s",
            -0.4 + 0.05 + 0.1 + 1.5 * v,
            0.005,
            "m",
            lambda r: r["box"].coordinate(1.5, 0),
            "v t",
            MECHANICS,
        ),
    )


def _distance(trace: Trace, name: str) -> float:
    """How far a body moves along x in 1 s, m."""
    return trace[name].coordinate(1, 0) - trace[name].coordinate(0, 0)


def _filtered() -> Iterator[Case]:
    shelf = body("shelf", box(1.0, 1.0, 0.1), (0, 0, 1.0), mass=None)
    pair = body(
        "box",
        box(0.2, 0.2, 0.2),
        (0, 0, 1.5),
        apis=["PhysicsFilteredPairsAPI"],
        attributes="        rel physics:filteredPairs = </World/shelf>\n",
    )
    group = """    def PhysicsCollisionGroup "Ghosts" (prepend apiSchemas = ["CollectionAPI:colliders"])
    {
        rel physics:filteredGroups = </World/Shelves>
        uniform token collection:colliders:expansionRule = "expandPrims"
        rel collection:colliders:includes = </World/box>
    }

    def PhysicsCollisionGroup "Shelves" (prepend apiSchemas = ["CollectionAPI:colliders"])
    {
        uniform token collection:colliders:expansionRule = "expandPrims"
        rel collection:colliders:includes = </World/shelf>
    }

"""
    plain = body("box", box(0.2, 0.2, 0.2), (0, 0, 1.5))
    through, source = 1.5 - G / 2 * 0.8**2, "UsdPhysics, Collision Filtering"
    for name, text, answer in (
        ("filtered_pair", stage(shelf, pair), through),
        ("collision_group", stage(shelf, plain, group), through),
        ("unfiltered", stage(shelf, plain), 1.15),
    ):
        formula = "g t²/2" if answer == through else "it lies on the shelf"
        yield make_case(
            name,
            text,
            0.8,
            Criterion(
                "height after 0.8 s of a box that starts above a shelf",
                answer,
                0.003,
                "m",
                lambda r: r["box"].coordinate(0.8, 2),
                formula,
                source,
            ),
        )
    upright = body("mug", cylinder(0.05, 0.1), (0, 0, 0.05))
    yield make_case(
        "stand_cylinder",
        stage(floor(), upright),
        2.0,
        Criterion(
            "displacement of a standing cylinder in 2 s",
            0.0,
            0.5,
            "mm",
            lambda r: float(1e3 * np.linalg.norm(r["mug"].position[480] - r["mug"].position[0])),
            "0",
            MECHANICS,
        ),
    )
