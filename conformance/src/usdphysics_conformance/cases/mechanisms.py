"""Joints that mimic others, and jointed bodies with initial velocities."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, degrees, exp, pi, radians, sin, sqrt

import numpy as np

from usdphysics_conformance.case import SAMPLE_RATE, Case, Criterion, Trace, make_case
from usdphysics_conformance.cases.joints import swing
from usdphysics_conformance.quaternions import Array, rotate
from usdphysics_conformance.reference import LANDAU, MECHANICS
from usdphysics_conformance.stages import G, Vector, ball, body, box, joint, stage

_SMALL = box(0.1, 0.1, 0.1)
_CONSTRAINED = "Lagrange's equations with a constraint"


def build_cases() -> Iterator[Case]:
    """The cases."""
    yield from _mimics()
    yield from _pushed()
    yield from _thrown()


def _mimics() -> Iterator[Case]:
    mass, inertia, pace = 2.0, 0.05, 5.0
    fall = mass * G / (mass + inertia * pace**2)
    yield make_case(
        "mimic_hoist",
        stage(
            body("weight", _SMALL, mass=mass),
            body("drum", _SMALL, (0, 1, 0), moments=(inertia,) * 3),
            joint("Prismatic", "rope", "", "weight", axis="Z"),
            joint("Revolute", "axle", "", "drum", (0, 1, 0), axis="Y", mimic=("rope", 0.0, degrees(pace))),
        ),
        0.5,
        Criterion(
            "distance fallen in 0.4 s by a weight that turns a drum",
            fall / 2 * 0.4**2,
            0.004,
            "m",
            lambda r: -r["weight"].coordinate(0.4, 2),
            "t²/2 mg/(m + I k²)",
            _CONSTRAINED,
        ),
        Criterion(
            "largest error of the drum's angle",
            0.0,
            0.005,
            "rad",
            lambda r: max(
                abs(r["drum"].rotation_angle(i / SAMPLE_RATE) + pace * r["weight"].position[i, 2]) for i in range(97)
            ),
            "0",
            "newton:mimicCoef1",
        ),
    )
    heavy, light = 3.0, 1.0
    yield make_case(
        "mimic_counterweight",
        stage(
            body("carriage", _SMALL, mass=1.0),
            body("heavy", _SMALL, (0.5, 0, 0), mass=heavy),
            body("light", _SMALL, (-0.5, 0, 0.2), mass=light),
            joint("Fixed", "post", "", "carriage"),
            joint("Prismatic", "one", "carriage", "heavy", (0.5, 0, 0), axis="Z"),
            joint(
                "Prismatic", "other", "carriage", "light", (-0.5, 0, 0), axis="Z", mimic=("one", 0.2, -1.0), physx=True
            ),
        ),
        0.5,
        Criterion(
            "distance fallen in 0.5 s by a weight that lifts a lighter one",
            G * (heavy - light) / (heavy + light) / 2 * 0.5**2,
            0.004,
            "m",
            lambda r: -r["heavy"].coordinate(0.5, 2),
            "g t²/2 (M − m)/(M + m)",
            MECHANICS,
        ),
        Criterion(
            "largest sum of the displacements of both weights, which should be opposite",
            0.0,
            0.5,
            "mm",
            lambda r: float(1e3 * np.abs(r["heavy"].position[:, 2] + r["light"].position[:, 2] - 0.2).max()),
            "0",
            "physxMimicJoint:gearing, offset",
        ),
    )
    whole, stiff = 1.0, 100.0
    damped = 2 * sqrt(stiff * whole)
    w, t = sqrt(stiff / whole), 0.2
    drive = f"stiffness = {stiff}\ndamping = {damped}\ntargetPosition = 0.04\nmaxForce = inf"
    yield make_case(
        "mimic_gripper",
        stage(
            body("palm", _SMALL, mass=1.0),
            body("left", box(0.02, 0.02, 0.05), (0, 0, 0.2), mass=0.7),
            body("right", box(0.02, 0.02, 0.05), (0, 0, -0.2), mass=0.3),
            joint("Fixed", "wrist", "", "palm"),
            joint("Prismatic", "finger", "palm", "left", (0, 0, 0.2), axis="Y", drive=drive),
            joint("Prismatic", "thumb", "palm", "right", (0, 0, -0.2), axis="Y", mimic=("finger", 0.0, -1.0)),
            gravity=0,
        ),
        0.5,
        Criterion(
            "position after 0.2 s of a finger that mimics a driven one",
            -40 * (1 - exp(-w * t) * (1 + w * t)),
            0.4,
            "mm",
            lambda r: 1e3 * r["right"].coordinate(0.2, 1),
            "the step response of a damped oscillator of both masses",
            MECHANICS,
        ),
    )


_ARM = 0.5
_INERTIA = 0.01


def _pushed() -> Iterator[Case]:
    reach = radians(60)
    spin = sqrt(2 * G * _ARM * (1 - cos(reach)) / (_INERTIA + _ARM**2))
    period = swing(reach, _INERTIA, _ARM)
    hung = joint("Revolute", "pivot", "", "bob", local_pos1=(0, 0, _ARM), axis="Y")
    down: Vector = (0, 0, -_ARM)
    bob = {"moments": (_INERTIA,) * 3, "velocity": (spin * _ARM, 0, 0), "angular_velocity": (0, -spin, 0)}
    yield make_case(
        "pendulum_pushed",
        stage(body("bob", ball(0.05), down, **bob), hung),  # type: ignore[arg-type]
        1.3 * period,
        Criterion(
            "amplitude of a pendulum that starts at its lowest point with a velocity",
            degrees(reach),
            0.3,
            "deg",
            lambda r: degrees(float(np.arcsin(np.abs(r["bob"].position[:, 0]).max() / _ARM))),
            "cos θ = 1 − (I + md²)ω²/2mgd",
            LANDAU,
        ),
        Criterion(
            "time of its second return to the lowest point",
            period,
            0.005 * period,
            "s",
            lambda r: _back(r["bob"].position[:, 0]),
            "4 √(I/mgd) K(sin θ/2)",
            LANDAU,
        ),
    )
    speed = 2.0
    yield make_case(
        "pendulum_jerked",
        stage(body("bob", ball(0.05), down, moments=(0.1,) * 3, velocity=(speed, 0, 1.0)), hung, gravity=0),
        0.2,
        Criterion(
            "angular speed of a pendulum whose initial velocity violates its joint",
            speed * _ARM / (0.1 + _ARM**2),
            0.01,
            "rad/s",
            lambda r: float(np.linalg.norm(r["bob"].angular_velocity[SAMPLE_RATE // 10])),
            "m d v/(I + md²)",
            "angular momentum about the joint",
        ),
    )
    lean = radians(40)
    around = sqrt(G / (_ARM * cos(lean)))
    at: Vector = (_ARM * sin(lean), 0, -_ARM * cos(lean))
    turn = (cos(lean / 2), 0.0, -sin(lean / 2), 0.0)
    yield make_case(
        "pendulum_conical",
        stage(
            body(
                "bob",
                ball(0.05),
                at,
                turn,
                moments=(_INERTIA,) * 3,
                velocity=(0, around * at[0], 0),
                angular_velocity=(0, 0, around),
            ),
            joint("Spherical", "pivot", "", "bob", local_pos1=(0, 0, _ARM)),
        ),
        1.25 * 2 * pi / around,
        Criterion(
            "largest change of the height of a conical pendulum",
            0.0,
            2.0,
            "mm",
            lambda r: float(1e3 * np.abs(r["bob"].position[:, 2] - at[2]).max()),
            "0",
            LANDAU,
        ),
        Criterion(
            "period of a conical pendulum",
            2 * pi / around,
            0.01,
            "s",
            lambda r: _back(r["bob"].position[:, 1]),
            "2π √(d cos θ/g)",
            LANDAU,
        ),
    )


def _back(x: Array) -> float:
    """When (s) a coordinate that begins at 0 first crosses 0 upwards; nan if it does not."""
    passed = [i - x[i] / (x[i + 1] - x[i]) for i in range(SAMPLE_RATE // 4, len(x) - 1) if x[i] < 0 <= x[i + 1]]
    return float(passed[0] / SAMPLE_RATE) if passed else float("nan")


def _thrown() -> Iterator[Case]:
    turns, sideways = 3.0, 1.0
    pair = [("one", -0.2, 1.0), ("other", 0.2, 3.0)]
    middle = 0.1  # of both, weighed
    parts = [
        body(
            name,
            ball(0.05),
            (x, 0, 5),
            mass=mass,
            velocity=(sideways, turns * (x - middle), 0),
            angular_velocity=(0, 0, turns),
        )
        for name, x, mass in pair
    ]
    yield make_case(
        "dumbbell_thrown",
        stage(*parts, joint("Fixed", "bar", "one", "other", (0.2, 0, 0), (-0.2, 0, 0))),
        1.0,
        Criterion(
            "largest deviation of the centre of mass of a thrown, rotating dumbbell from the parabola",
            0.0,
            1.0,
            "mm",
            lambda r: float(1e3 * np.abs(_middle(r) - _flight(middle, sideways, len(_middle(r)))).max()),
            "p + vt + gt²/2",
            MECHANICS,
        ),
        Criterion(
            "rotation of the bar in 1 s",
            turns,
            0.01,
            "rad",
            lambda r: r["one"].rotation_angle(1.0),
            "ωt",
            MECHANICS,
        ),
    )
    spins = {"left": (0.0, 0.0, 4.0), "right": (0.0, 0.0, -1.0)}
    places = {"left": (-0.25, 0.0, 0.0), "right": (0.25, 0.0, 0.0)}
    moments = (0.01, 0.03, 0.03)
    links = [
        body(
            name,
            box(0.4, 0.05, 0.05),
            places[name],
            moments=moments,
            velocity=tuple(np.cross(spins[name], places[name]).tolist()),
            angular_velocity=spins[name],
        )
        for name in places
    ]
    momentum = sum(0.03 * spins[n][2] + 0.25**2 * spins[n][2] for n in places)
    yield make_case(
        "nunchaku_thrown",
        stage(*links, joint("Revolute", "chain", "left", "right", (0.25, 0, 0), (-0.25, 0, 0), axis="Z"), gravity=0),
        1.0,
        Criterion(
            "angular momentum of two rods on a hinge after 1 s",
            momentum,
            0.005,
            "Nms",
            _momentum,
            "constant",
            MECHANICS,
        ),
        Criterion(
            "largest gap in their hinge",
            0.0,
            0.1,
            "mm",
            lambda r: float(1e3 * np.abs(_end(r, "left", 0.25) - _end(r, "right", -0.25)).max()),
            "0",
            MECHANICS,
        ),
    )


def _middle(trace: Trace) -> Array:
    middle: Array = (trace["one"].position + 3 * trace["other"].position) / 4
    return middle


def _flight(x: float, speed: float, samples: int) -> Array:
    time = np.arange(samples) / SAMPLE_RATE
    return np.stack([x + speed * time, np.zeros(samples), 5 - G * time**2 / 2], axis=1)


def _end(trace: Trace, name: str, along: float) -> Array:
    return trace[name].position + rotate(trace[name].orientation, np.array([along, 0.0, 0.0]))


def _momentum(trace: Trace) -> float:
    """The angular momentum (Nms) along z about the centre of mass of both rods, of 1 kg each, at the end."""
    middle = sum(motion.position[-1] for motion in trace.values()) / 2
    pushed = sum(motion.linear_velocity[-1] for motion in trace.values()) / 2
    orbit = [np.cross(t.position[-1] - middle, t.linear_velocity[-1] - pushed)[2] for t in trace.values()]
    return float(sum(orbit) + sum(0.03 * t.angular_velocity[-1, 2] for t in trace.values()))
