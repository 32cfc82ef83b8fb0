"""Free flight, and one body on a floor or a slope: sliding, rolling, bouncing, tipping, standing."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan, cos, degrees, hypot, pi, radians, sin, sqrt, tan

import numpy as np

from usdphysics_conformance.case import Case, Criterion, Motion, Trace, make_case
from usdphysics_conformance.reference import DZHANIBEKOV_TIME, LANDAU, MECHANICS
from usdphysics_conformance.stages import G, ball, body, box, cylinder, floor, prism, stage


def build_cases() -> Iterator[Case]:
    """The cases."""
    yield from _flight()
    yield from _spins()
    yield from _bounces()
    yield from _slides()
    yield from _rolls()
    yield from _stands()


# ---------------------------------------------------------------- flight


def _flight() -> Iterator[Case]:
    def off(trace: Trace) -> float:
        t = np.arange(len(trace["ball"].position)) / 240
        fallen = trace["ball"].position[0] + t[:, None] * [1.5, 0.5, 3.0] - [0, 0, G / 2] * t[:, None] ** 2
        return float(1e3 * np.abs(trace["ball"].position - fallen).max())

    yield make_case(
        "free_fall",
        stage(body("ball", ball(0.1), (0, 0, 10))),
        1.0,
        Criterion(
            "distance fallen in 1 s", G / 2, 0.0005, "m", lambda r: 10 - r["ball"].coordinate(1, 2), "g t²/2", MECHANICS
        ),
    )
    yield make_case(
        "projectile",
        stage(body("ball", ball(0.1), (0, 0, 10), velocity=(1.5, 0.5, 3.0))),
        1.0,
        Criterion("largest deviation from the parabola in 1 s", 0.0, 0.5, "mm", off, "p + v t + g t²/2", MECHANICS),
    )
    centimetres = stage(body("ball", ball(10.0), (0, 1000.0, 0), mass=1000.0), gravity=100 * G)
    centimetres = centimetres.replace("metersPerUnit = 1\n", "metersPerUnit = 0.01\n").replace(
        'upAxis = "Z"', 'upAxis = "Y"'
    )
    centimetres = centimetres.replace("kilogramsPerUnit = 1\n", "kilogramsPerUnit = 0.001\n").replace(
        "(0, 0, -1)", "(0, -1, 0)"
    )
    yield make_case(
        "units",
        centimetres,
        1.0,
        Criterion(
            "distance fallen in 1 s on a stage in centimetres and grams with Y up",
            G / 2,
            0.0005,
            "m",
            lambda r: float(np.linalg.norm(r["ball"].position[240] - r["ball"].position[0])),
            "g t²/2",
            MECHANICS,
        ),
    )


def _spins() -> Iterator[Case]:
    top = body("top", box(0.3, 0.3, 0.1), angular_velocity=(0.0, 0.0, 5.0), moments=(0.02, 0.02, 0.03))
    yield make_case(
        "spin",
        stage(top, gravity=0),
        1.0,
        Criterion(
            "rotation about a principal axis in 0.5 s",
            2.5,
            0.003,
            "rad",
            lambda r: r["top"].rotation_angle(0.5),
            "ω t",
            LANDAU,
        ),
    )
    moments = (0.02, 0.02, 0.03)
    w1, w3 = 1.0, 4.0
    nod = hypot(moments[0] * w1, moments[2] * w3) / moments[0]

    def precession(trace: Trace) -> float:
        momentum = np.array([moments[0] * w1, 0.0, moments[2] * w3])
        up = momentum / np.linalg.norm(momentum)
        axes = [trace["top"].axis_direction(t, 2) for t in (0.0, 0.25)]
        across = [axis - up * (axis @ up) for axis in axes]
        return float(np.arctan2(np.cross(*across) @ up, across[0] @ across[1]) % (2 * pi))

    yield make_case(
        "precession",
        stage(body("top", box(0.3, 0.3, 0.1), angular_velocity=(w1, 0.0, w3), moments=moments), gravity=0),
        0.5,
        Criterion(
            "angle of free precession in 0.25 s", 0.25 * nod % (2 * pi), 0.01, "rad", precession, "L t / I₁", LANDAU
        ),
    )
    yield make_case(
        "dzhanibekov",
        stage(
            body("key", box(0.4, 0.2, 0.1), angular_velocity=(0.02, 8.0, 0.02), moments=(0.01, 0.02, 0.028)), gravity=0
        ),
        4.0,
        Criterion(
            "time at which a body that spins about its intermediate axis flips",
            DZHANIBEKOV_TIME,
            0.02,
            "s",
            lambda r: _crossing(
                [float(r["key"].axis_direction(i / 240, 1)[1]) for i in range(len(r["key"].angular_velocity))]
            ),
            "Euler's equations, integrated to 1e-11",
            LANDAU,
        ),
    )


def _crossing(heights: list[float]) -> float:
    """When (s) the samples first cross 0 downwards; nan if they do not."""
    below = next((i for i, h in enumerate(heights) if h < 0), None)
    if below is None:
        return float("nan")
    before, after = heights[below - 1], heights[below]
    return (below - 1 + before / (before - after)) / 240


# ---------------------------------------------------------------- bounces


def _bounces() -> Iterator[Case]:
    for e in (0.0, 0.5, 0.8, 1.0):
        drop, start = 0.5, sqrt(2 * 0.5 / G)
        up = e * sqrt(2 * G * drop) / G
        top = start + up if e else start + 0.3

        def apex(trace: Trace, start: float = start, top: float = top, last: float = 0.02) -> float:
            z = trace["ball"].position[round(240 * (start + last)) : round(240 * (top + 0.1)), 2]
            return float(100 * (z.max() - 0.1) / 0.5)

        yield make_case(
            f"bounce_{e:g}",
            stage(floor(), body("ball", ball(0.1), (0, 0, 0.1 + drop)), restitution=e),
            top + 0.2,
            Criterion(
                "height of the bounce, relative to the height of the drop",
                100 * e * e,
                3.0,
                "%",
                apex,
                "e² h",
                MECHANICS,
            ),
        )
    struck = sqrt(2 * G * 1.2)
    yield make_case(
        "drop_on_box",
        stage(
            floor(),
            body("below", box(0.2, 0.2, 0.2), (0, 0, 0.1), mass=8.0),
            body("falls", box(0.4, 0.2, 0.2), (0, 0, 1.5), mass=16.0),
        ),
        0.8,
        Criterion(
            "largest upward speed of a heavy box after it falls on a lighter one at rest",
            0.0,
            0.03 * struck,
            "m/s",
            lambda r: float(r["falls"].linear_velocity[round(240 * (struck / G + 0.02)) :, 2].max()),
            "0",
            MECHANICS,
        ),
    )
    fall = sqrt(2 * G * 0.5)
    yield make_case(
        "bounce_oblique",
        stage(floor(), body("ball", ball(0.1), (0, 0, 0.6), velocity=(1.0, 0, 0)), friction=0, restitution=0.5),
        0.5,
        Criterion(
            "horizontal speed after the bounce",
            1.0,
            0.01,
            "m/s",
            lambda r: r["ball"].linear_velocity[100, 0],
            "v",
            MECHANICS,
        ),
        Criterion(
            "upward speed shortly after the bounce",
            0.5 * fall - G * (100 / 240 - sqrt(1 / G)),
            0.06,
            "m/s",
            lambda r: r["ball"].linear_velocity[100, 2],
            "e v − g t",
            MECHANICS,
        ),
    )
    yield make_case(
        "bounce_gripping",
        stage(floor(), body("ball", ball(0.1), (0, 0, 0.6), velocity=(1.0, 0, 0)), friction=1.0, restitution=0.5),
        0.5,
        Criterion(
            "horizontal speed after the bounce of a ball that grips the floor",
            5 / 7,
            0.03,
            "m/s",
            lambda r: r["ball"].linear_velocity[100, 0],
            "5 v/7",
            "Garwin, American Journal of Physics 37 (1969), without his tangential restitution",
        ),
    )
    yield make_case(
        "thin_wall",
        stage(
            body("wall", box(0.01, 2.0, 2.0), (1.0, 0, 0), mass=None),
            body("ball", ball(0.05), (0.5, 0, 0), velocity=(20.0, 0, 0)),
            gravity=0,
        ),
        0.25,
        Criterion(
            "largest penetration of a wall 1 cm thick that is hit at 20 m/s",
            0.0,
            5.0,
            "mm",
            lambda r: float(1e3 * max(0.0, r["ball"].position[:, 0].max() + 0.05 - 0.995)),
            "0",
            "what is solid is not entered",
        ),
    )


# ---------------------------------------------------------------- sliding


_SLID = {
    "box": (box(0.2, 0.2, 0.1), 0.05),
    "puck": (cylinder(0.1, 0.05), 0.025),
    "standing_cylinder": (cylinder(0.06, 0.1), 0.05),
    "prism_mesh": (prism(6, 0.08, 0.06), 0.03),
    "lying_cylinder": (cylinder(0.05, 0.3, "X"), 0.05),
}


def _slides() -> Iterator[Case]:
    mu, v = 0.3, 1.5
    stop = v * v / (2 * mu * G)
    for name, (shape, up) in _SLID.items():
        yield make_case(
            f"slide_{name}",
            stage(floor(), body("thing", shape, (0, 0, up), velocity=(v, 0, 0)), friction=mu),
            1.2,
            Criterion(
                "sliding distance until the body stops",
                stop,
                0.01 * stop,
                "m",
                lambda r: r["thing"].coordinate(1.2, 0),
                "v²/2μg",
                MECHANICS,
            ),
            Criterion(
                "largest sideways displacement",
                0.0,
                2.0,
                "mm",
                lambda r: float(1e3 * np.abs(r["thing"].position[:, 1]).max()),
                "0",
                "symmetry",
            ),
        )
    limit = atan(0.5)
    for name, angle in (("stick", limit - 0.03), ("slip", limit + 0.03)):
        turn = (cos(angle / 2), 0.0, sin(angle / 2), 0.0)
        at = (0.05 * sin(angle), 0.0, 0.05 * cos(angle))
        distance = 0.0 if name == "stick" else G * (sin(angle) - 0.5 * cos(angle)) * 2.0
        yield make_case(
            f"incline_{name}",
            stage(floor(turn), body("box", box(0.3, 0.3, 0.1), at, turn), friction=0.5),
            2.0,
            Criterion(
                f"distance slid down a slope of {degrees(angle):.2f} degrees in 2 s",
                distance,
                max(0.001, 0.01 * distance),
                "m",
                lambda r: float(np.linalg.norm(r["box"].position[480] - r["box"].position[0])),
                "g (sin α − μ cos α) t²/2" if distance else "0",
                MECHANICS,
            ),
        )
    angle = radians(27.0)
    turn, at = (cos(angle / 2), 0.0, sin(angle / 2), 0.0), (0.05 * sin(angle), 0.0, 0.05 * cos(angle))
    yield make_case(
        "two_frictions_rest",
        stage(floor(turn), body("box", box(0.3, 0.3, 0.1), at, turn), friction=(0.6, 0.4)),
        1.0,
        Criterion(
            "distance slid in 1 s on a slope where static friction should hold the box",
            0.0,
            1.0,
            "mm",
            lambda r: float(1e3 * np.linalg.norm(r["box"].position[240] - r["box"].position[0])),
            "0, as tan α < μ at rest",
            MECHANICS,
        ),
    )
    two = v * v / (2 * 0.4 * G)
    yield make_case(
        "two_frictions_motion",
        stage(floor(), body("box", box(0.2, 0.2, 0.1), (0, 0, 0.05), velocity=(v, 0, 0)), friction=(0.6, 0.4)),
        1.0,
        Criterion(
            "sliding distance until the body stops",
            two,
            0.02 * two,
            "m",
            lambda r: r["box"].coordinate(1.0, 0),
            "v²/2μg in motion",
            MECHANICS,
        ),
    )
    yield from _spun_puck()


def _spun_puck() -> Iterator[Case]:
    """A disc that spins on a floor.

    Rigid-body mechanics does not determine the pressure under it: friction is least with a uniform pressure and
    greatest with all of it on the rim, so the answer is a range.
    """
    mu, radius, w = 0.3, 0.1, 10.0
    even, rim = (w - 0.1 * share * mu * G / radius for share in (4 / 3, 2.0))
    yield make_case(
        "puck_spun",
        stage(floor(), body("disc", cylinder(radius, 0.05), (0, 0, 0.025), angular_velocity=(0, 0, w)), friction=mu),
        0.2,
        Criterion(
            "angular speed of a disc on a floor after 0.1 s",
            (even + rim) / 2,
            (even - rim) / 2 + 0.05,
            "rad/s",
            lambda r: r["disc"].angular_velocity[24, 2],
            "from ω − 2μg t/r, all weight on the rim, to ω − 4μg t/3r, weight spread evenly",
            MECHANICS,
        ),
    )


# ---------------------------------------------------------------- rolling


def _rolls() -> Iterator[Case]:
    r, v = 0.1, 1.0
    for name, shape, share in (("ball", ball(r), 2 / 5), ("cylinder", cylinder(r, 0.2, "Y"), 1 / 2)):
        yield make_case(
            f"roll_{name}",
            stage(floor(), body("thing", shape, (0, 0, r), velocity=(v, 0, 0), angular_velocity=(0, v / r, 0))),
            3.0,
            Criterion(
                "speed after rolling for 3 s", v, 0.01, "m/s", lambda trace: trace["thing"].speed(3), "v", MECHANICS
            ),
        )
        yield make_case(
            f"slide_to_roll_{name}",
            stage(floor(), body("thing", shape, (0, 0, r), velocity=(v, 0, 0)), friction=0.3),
            1.5,
            Criterion(
                "speed once the body rolls without slipping",
                v / (1 + share),
                0.01,
                "m/s",
                lambda trace: trace["thing"].speed(1.5),
                "v/(1 + k²/r²)",
                MECHANICS,
            ),
        )
        angle = radians(15)
        turn = (cos(angle / 2), 0.0, sin(angle / 2), 0.0)
        distance = G * sin(angle) / (1 + share) / 2
        assert share / (1 + share) * tan(angle) < 0.5
        yield make_case(
            f"roll_down_{name}",
            stage(floor(turn), body("thing", shape, (r * sin(angle), 0, r * cos(angle)))),
            1.0,
            Criterion(
                "distance rolled down a slope of 15 degrees in 1 s",
                distance,
                0.01 * distance,
                "m",
                lambda trace: float(np.linalg.norm(trace["thing"].position[240] - trace["thing"].position[0])),
                "g sin α t²/2(1 + k²/r²)",
                MECHANICS,
            ),
        )


# ---------------------------------------------------------------- standing


def _stands() -> Iterator[Case]:
    limit = atan(0.1 / 0.3)
    for name, angle in (("topple", limit + 0.02), ("stand", limit - 0.02)):
        turn = (cos(angle / 2), 0.0, sin(angle / 2), 0.0)
        at = (0.15 * sin(angle), 0.0, 0.15 * cos(angle))
        yield make_case(
            name,
            stage(floor(turn), body("box", box(0.1, 0.1, 0.3), at, turn), friction=1.0),
            2.0,
            Criterion(
                f"rotation of a box 3 times as high as wide on a slope of {degrees(angle):.2f} degrees",
                90.0 if name == "topple" else 0.0,
                2.0,
                "deg",
                lambda r: degrees(r["box"].rotation_angle(2.0)),
                "tips from atan(b/h) on",
                MECHANICS,
            ),
        )
    for name, angle in (("topple_cylinder", limit + 0.02), ("stand_cylinder_slope", limit - 0.02)):
        turn, yaw = (cos(angle / 2), 0.0, sin(angle / 2), 0.0), pi / 8
        own = (turn[0] * cos(yaw / 2), turn[2] * sin(yaw / 2), turn[2] * cos(yaw / 2), turn[0] * sin(yaw / 2))
        at = (0.15 * sin(angle), 0.0, 0.15 * cos(angle))
        yield make_case(
            name,
            stage(floor(turn), body("can", cylinder(0.05, 0.3), at, own), friction=1.0),
            0.7,
            Criterion(
                f"tilt of a cylinder 3 times as high as wide on a slope of {degrees(angle):.2f} degrees",
                90.0 if name == "topple_cylinder" else 0.0,
                60.0 if name == "topple_cylinder" else 2.0,
                "deg",
                lambda r: _tilt(r["can"], 0.7),
                "tips from atan(d/h) on",
                MECHANICS,
            ),
        )
    boxes = [body(f"box{i}", box(0.2, 0.2, 0.1), (0, 0, 0.05 + 0.1 * i)) for i in range(5)]
    yield make_case(
        "stack",
        stage(floor(), *boxes),
        3.0,
        Criterion(
            "largest displacement of a box in a stack of five in 3 s",
            0.0,
            0.5,
            "mm",
            lambda r: float(1e3 * max(np.linalg.norm(t.position[720] - t.position[0]) for t in r.values())),
            "0",
            MECHANICS,
        ),
    )


def _tilt(motion: Motion, time: float) -> float:
    """The angle (degrees) between the body's z axis at the start and at a time (s)."""
    cosine = motion.axis_direction(time, 2) @ motion.axis_direction(0, 2)
    return degrees(float(np.arccos(np.clip(cosine, -1, 1))))
