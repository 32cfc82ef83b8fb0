"""Pendulums, linkages, drives, limits."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, degrees, exp, pi, radians, sin, sqrt
from typing import Any

import numpy as np

from usdphysics_conformance.case import SAMPLE_RATE, Case, Criterion, Trace, make_case
from usdphysics_conformance.quaternions import Array
from usdphysics_conformance.reference import DOUBLE_PENDULUM_END, LANDAU, MECHANICS, elliptic_k
from usdphysics_conformance.stages import G, Vector, ball, body, box, joint, stage

_ARM = 0.5  # m, from the pivot to the middle of the bob
_INERTIA = (0.01, 0.01, 0.01)


def build_cases() -> Iterator[Case]:
    """The cases."""
    yield from _pendulums()
    yield from _linkages()
    yield from _drives()
    yield from _limits()
    yield from _constrained()


def swing(amplitude: float, inertia: float, arm: float, mass: float = 1.0) -> float:
    """The period (s) of a pendulum released at an amplitude (rad): Landau and Lifshitz, Mechanics, § 11."""
    return float(4 * sqrt((inertia + mass * arm**2) / (mass * G * arm)) * elliptic_k(sin(amplitude / 2) ** 2))


def _hung(angle: float) -> tuple[Vector, tuple[float, ...]]:
    """Position and orientation of a bob on a pendulum from the origin, at an angle (rad) about y from the vertical."""
    return (_ARM * sin(angle), 0.0, -_ARM * cos(angle)), (cos(angle / 2), 0.0, -sin(angle / 2), 0.0)


def _period(trace: Trace, name: str = "bob", middle: float = 0.0) -> float:
    """The time (s) between two crossings of x = `middle` in one direction; nan without two crossings."""
    x = trace[name].position[:, 0] - middle
    passed = [i + x[i] / (x[i] - x[i + 1]) for i in range(len(x) - 1) if x[i] > 0 >= x[i + 1]]
    return float((passed[1] - passed[0]) / SAMPLE_RATE) if len(passed) > 1 else float("nan")


def _pendulums() -> Iterator[Case]:
    hinged = [(f"{angle}", "Revolute", angle, f"released at {angle} degrees") for angle in (10, 60, 150)]
    for name, kind, angle, how in (*hinged, ("ball_joint", "Spherical", 60, "on a ball joint")):
        at, turn = _hung(radians(angle))
        bob = body("bob", ball(0.05), at, turn, moments=_INERTIA)
        text = stage(bob, joint(kind, "pivot", "", "bob", local_pos1=(0, 0, _ARM), axis="Y"))
        period = swing(radians(angle), 0.01, _ARM)
        yield make_case(
            f"pendulum_{name}",
            text,
            2.6 * period,
            Criterion(
                f"period of a pendulum {how}", period, 0.005 * period, "s", _period, "4 √(I/mgd) K(sin θ/2)", LANDAU
            ),
        )
    yield from _double()


def _energy(trace: Trace, names: tuple[str, ...], moment: float) -> Array:
    """Kinetic and potential energy (T,) of bodies of 1 kg, J."""
    whole = np.zeros(len(trace[names[0]].position))
    for name in names:
        motion = trace[name]
        squares = (motion.linear_velocity**2).sum(axis=1) + moment * (motion.angular_velocity**2).sum(axis=1)
        whole += squares / 2 + G * motion.position[:, 2]
    return whole


def _double() -> Iterator[Case]:
    arms = [
        body("upper", box(0.05, 0.05, 0.05), (0.25, 0, 0), moments=_INERTIA),
        body("lower", box(0.05, 0.05, 0.05), (0.75, 0, 0), moments=_INERTIA),
        joint("Revolute", "shoulder", "", "upper", local_pos1=(-0.25, 0, 0), axis="Y"),
        joint("Revolute", "elbow", "upper", "lower", (0.25, 0, 0), (-0.25, 0, 0), axis="Y"),
    ]

    def drift(trace: Trace) -> float:
        energy = _energy(trace, ("upper", "lower"), _INERTIA[0])
        return float(100 * np.abs(energy[24:] - energy[0]).max() / (2 * G * 0.5))

    yield make_case(
        "double_pendulum",
        stage(*arms),
        3.0,
        Criterion(
            "distance of the lower bob from the exact position after 1 s",
            0.0,
            5.0,
            "mm",
            lambda r: float(1e3 * np.linalg.norm(r["lower"].position[SAMPLE_RATE] - DOUBLE_PENDULUM_END)),
            "Lagrange's equations, integrated to 1e-11",
            LANDAU,
        ),
        Criterion(
            "largest change of the energy, as a share of the energy of a fall by 0.5 m",
            0.0,
            1.0,
            "%",
            drift,
            "constant",
            LANDAU,
        ),
        Criterion(
            "largest distance from the plane of motion",
            0.0,
            0.5,
            "mm",
            lambda r: float(1e3 * np.abs(r["lower"].position[:, 1]).max()),
            "0",
            "symmetry",
        ),
    )


def _linkages() -> Iterator[Case]:
    """A parallelogram: its coupler never turns, so it swings as a point that one of its cranks carries."""
    angle, crank, wide = radians(30), 0.4, 0.6
    down: Vector = (crank / 2 * sin(angle), 0.0, -crank / 2 * cos(angle))
    turn = (cos(angle / 2), 0.0, -sin(angle / 2), 0.0)
    parts = []
    for name, x in (("left", -wide / 2), ("right", wide / 2)):
        parts.append(body(name, box(0.02, 0.02, 0.02), (x + down[0], 0, down[2]), turn, mass=0.5, moments=(0.005,) * 3))
        parts.append(joint("Revolute", f"{name}_top", "", name, (x, 0, 0), (0, 0, crank / 2), axis="Y"))
    parts.append(body("coupler", box(0.02, 0.02, 0.02), (2 * down[0], 0, 2 * down[2]), mass=2.0, moments=(0.05,) * 3))
    parts.append(joint("Revolute", "left_low", "left", "coupler", (0, 0, -crank / 2), (-wide / 2, 0, 0), axis="Y"))
    parts.append(joint("Revolute", "right_low", "right", "coupler", (0, 0, -crank / 2), (wide / 2, 0, 0), axis="Y"))
    # T = ½ (2 (I + m c²/4) + M c²) θ'², V = −(2 m c/2 + M c) g cos θ
    inertia, pull = 2 * (0.005 + 0.5 * crank**2 / 4) + 2.0 * crank**2, (0.5 * crank + 2.0 * crank) * G
    period = float(4 * sqrt(inertia / pull) * elliptic_k(sin(angle / 2) ** 2))
    yield make_case(
        "four_bar",
        stage(*parts),
        2.6 * period,
        Criterion(
            "period of a swinging parallelogram linkage",
            period,
            0.005 * period,
            "s",
            lambda r: _period(r, "coupler"),
            "4 √(I/P) K(sin θ/2)",
            LANDAU,
        ),
        Criterion(
            "largest rotation of its coupler",
            0.0,
            0.2,
            "deg",
            lambda r: degrees(
                max(
                    r["coupler"].rotation_angle(i / SAMPLE_RATE)
                    for i in range(0, len(r["coupler"].angular_velocity), 24)
                )
            ),
            "0",
            "geometry",
        ),
    )


def _cart(axis: str, gravity: float = G, **options: Any) -> str:
    """The stage of a cart on a rail along an axis; `options` are those of its joint."""
    rail = joint("Prismatic", "rail", "", "cart", axis=axis, **options)
    return stage(body("cart", box(0.1, 0.1, 0.1)), rail, gravity=gravity)


def _drives() -> Iterator[Case]:
    m, k = 1.0, 100.0
    w = sqrt(k / m)
    for name, damping in (("critical", 2 * sqrt(k * m)), ("light", 0.2 * 2 * sqrt(k * m))):
        zeta = damping / (2 * sqrt(k * m))
        t = 0.2
        if zeta == 1:
            response = 1 - exp(-w * t) * (1 + w * t)
        else:
            d = w * sqrt(1 - zeta**2)
            response = 1 - exp(-zeta * w * t) * (cos(d * t) + zeta * w / d * sin(d * t))
        drive = f"stiffness = {k}\ndamping = {damping}\ntargetPosition = 0.3\nmaxForce = inf"
        yield make_case(
            f"drive_{name}",
            _cart("X", gravity=0, drive=drive),
            0.5,
            Criterion(
                f"position of a driven cart after {t:g} s",
                300 * response,
                3.0,
                "mm",
                lambda r: 1e3 * r["cart"].coordinate(0.2, 0),
                "the step response of a damped oscillator",
                MECHANICS,
            ),
        )
    spring = f"stiffness = {k}\ndamping = 0\ntargetPosition = 0.2\nmaxForce = inf"
    yield make_case(
        "spring",
        _cart("X", gravity=0, drive=spring),
        1.8,
        Criterion(
            "period of a mass on a spring",
            2 * pi / w,
            0.005,
            "s",
            lambda r: _period(r, "cart", 0.2),
            "2π √(m/k)",
            MECHANICS,
        ),
        Criterion(
            "largest displacement of the mass",
            400.0,
            4.0,
            "mm",
            lambda r: float(1e3 * r["cart"].position[:, 0].max()),
            "2 x",
            MECHANICS,
        ),
    )
    turned = "stiffness = 1.0\ndamping = 0.1\ntargetPosition = 40\nmaxForce = inf"
    yield make_case(
        "drive_hinge",
        stage(
            body("arm", box(0.2, 0.1, 0.05), moments=(0.1,) * 3),
            joint("Revolute", "axle", "", "arm", axis="Z", drive=turned),
            gravity=0,
        ),
        3.0,
        Criterion(
            "final angle of a hinge; stiffness and damping of its drive are per degree",
            40.0,
            0.2,
            "deg",
            lambda r: degrees(r["arm"].rotation_angle(3.0)),
            "its target",
            "UsdPhysics, PhysicsDriveAPI",
        ),
    )
    speed = "stiffness = 0\ndamping = 200\ntargetVelocity = 0.7\nmaxForce = inf"
    yield make_case(
        "drive_velocity",
        _cart("X", gravity=0, drive=speed),
        0.5,
        Criterion(
            "speed of a cart with a velocity drive",
            0.7,
            0.003,
            "m/s",
            lambda r: r["cart"].speed(0.5),
            "its target",
            MECHANICS,
        ),
    )
    weak = "stiffness = 100000\ndamping = 100\ntargetPosition = 1\nmaxForce = 5"
    yield make_case(
        "drive_force_limit",
        _cart("Z", drive=weak),
        0.5,
        Criterion(
            "distance that 1 kg falls in 0.4 s against a drive of at most 5 N",
            (G - 5) / 2 * 0.4**2,
            0.004,
            "m",
            lambda r: -r["cart"].coordinate(0.4, 2),
            "(g − F/m) t²/2",
            MECHANICS,
        ),
    )


def _limits() -> Iterator[Case]:
    at, turn = _hung(pi / 2)
    text = stage(
        body("bob", ball(0.05), at, turn, moments=_INERTIA),
        joint("Revolute", "pivot", "", "bob", local_pos1=(0, 0, _ARM), axis="Y", limits=(-120.0, -30.0)),
    )
    yield make_case(
        "limit_hinge",
        text,
        3.0,
        Criterion(
            "angle at which a limit stops a falling pendulum",
            30.0,
            0.5,
            "deg",
            lambda r: degrees(np.arctan2(r["bob"].coordinate(3, 0), -r["bob"].coordinate(3, 2))),
            "the limit",
            "UsdPhysics, PhysicsRevoluteJoint",
        ),
    )
    yield make_case(
        "limit_slider",
        _cart("Z", limits=(-0.25, 0.25)),
        2.0,
        Criterion(
            "position at which a limit stops a falling cart",
            -250.0,
            1.0,
            "mm",
            lambda r: 1e3 * r["cart"].coordinate(2, 2),
            "the limit",
            "UsdPhysics, PhysicsPrismaticJoint",
        ),
    )


def _constrained() -> Iterator[Case]:
    yield make_case(
        "rail",
        _cart("X"),
        1.0,
        Criterion(
            "displacement of a cart on a level rail in 1 s",
            0.0,
            0.5,
            "mm",
            lambda r: float(1e3 * np.linalg.norm(r["cart"].position[240] - r["cart"].position[0])),
            "0",
            MECHANICS,
        ),
    )
    yield make_case(
        "dumbbell",
        stage(
            body("one", ball(0.05), (-0.2, 0, 5), mass=1.0),
            body("other", ball(0.05), (0.2, 0, 5), mass=3.0),
            joint("Fixed", "bar", "one", "other", (0.2, 0, 0), (-0.2, 0, 0)),
        ),
        1.0,
        Criterion(
            "distance fallen in 1 s by two balls on a bar",
            G / 2,
            0.001,
            "m",
            lambda r: 5 - r["other"].coordinate(1, 2),
            "g t²/2",
            MECHANICS,
        ),
        Criterion(
            "change of the length of the bar",
            0.0,
            0.1,
            "mm",
            lambda r: float(1e3 * abs(np.linalg.norm(r["one"].position[240] - r["other"].position[240]) - 0.4)),
            "0",
            MECHANICS,
        ),
    )
