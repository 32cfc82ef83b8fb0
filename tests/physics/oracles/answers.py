"""How far episodes are from what mechanics says.

Errors are in SI units, or a share of the quantity where that is what is compared. Sources: any textbook of mechanics,
e.g. Goldstein, Poole and Safko, Classical Mechanics; rolling balls also Cross, Am. J. Phys. 70 (2002) 1093.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import atan, cos, pi, radians, sin, sqrt

import numpy as np

from tests.physics.oracles.runs import Motion, Run
from wmspec.sim.scene.model import Array
from wmspec.sim.scene.model.transform import rotate, rotation

G = 9.81
Runs = Sequence[Run]


def worst(error: Callable[[Run], float], where: Callable[[Run], bool] = lambda _: True) -> Callable[[Runs], float]:
    """The largest error of the runs, of those that `where` picks."""

    def of(runs: Runs) -> float:
        chosen = [error(run) for run in runs if where(run)]
        assert chosen
        return max(chosen)

    return of


# ---------------------------------------------------------------- what is measured in several scenes


def momentum(run: Run, sample: int) -> Array:
    """The sum of m v (3,) of all that moves."""
    total: Array = sum((m.mass * m.velocity[sample] for m in run.moving), np.zeros(3))
    return total


def center(motion: Motion) -> Array:
    """Where the centre of mass is, (T, 3)."""
    inertia = motion.body.inertia
    assert inertia is not None
    place: Array = motion.position + rotate(motion.orientation, inertia.center)
    return place


def turning(motion: Motion, sample: int) -> Array:
    """The angular momentum (3,) about the centre of mass, in world axes."""
    inertia = motion.body.inertia
    assert inertia is not None
    axes = rotation(motion.orientation[sample]) @ rotation(inertia.axes)
    total: Array = axes @ (inertia.moments * (axes.T @ motion.spin[sample]))
    return total


def angular_momentum(run: Run, sample: int) -> Array:
    """The sum of r × m v and of spins (3,) of all that moves, about the origin."""
    total = np.zeros(3)
    for m in run.moving:
        total += np.cross(center(m)[sample], m.mass * m.velocity[sample]) + turning(m, sample)
    return total


def kinetic(run: Run, sample: int) -> float:
    """The energy of motion, J."""
    return sum(
        float(m.mass * m.velocity[sample] @ m.velocity[sample] + turning(m, sample) @ m.spin[sample]) / 2
        for m in run.moving
    )


def lost_momentum(run: Run) -> float:
    """The change of momentum in the plane of the floor, as a share of what there was."""
    before, after = momentum(run, 0)[:2], momentum(run, -1)[:2]
    return float(np.linalg.norm(after - before) / np.linalg.norm(before))


def lost_angular_momentum(run: Run) -> float:
    """Its change, as a share of what there was."""
    before, after = angular_momentum(run, 0), angular_momentum(run, -1)
    return float(np.linalg.norm(after - before) / np.linalg.norm(before))


def changed_energy(run: Run) -> float:
    """The change of kinetic energy, as a share of what there was."""
    return abs(kinetic(run, -1) / kinetic(run, 0) - 1)


def gained_energy(run: Run) -> float:
    """As `changed_energy`, of what may lose energy and not gain any."""
    return max(0.0, kinetic(run, -1) / kinetic(run, 0) - 1)


# ---------------------------------------------------------------- scene by scene


def off_parabola(run: Run) -> float:
    """The largest distance from p + v t + g t²/2, m."""
    ball, t = run["ball"], run.trace.time[:, None]
    heading = run.factor("heading")
    v = run.factor("speed") * np.array([cos(heading), sin(heading), 0])
    expected = ball.position[0] + v * t + run.scene.gravity * t**2 / 2
    return float(np.abs(ball.position - expected).max())


def falling_energy(run: Run) -> float:
    """The largest change of energy, as a share of the potential energy that became kinetic."""
    ball = run["ball"]
    total = (ball.velocity**2).sum(axis=1) / 2 + G * ball.position[:, 2]
    return float(np.abs(total - total[0]).max() / (G * (ball.position[0, 2] - ball.position[-1, 2])))


def stopping(run: Run) -> float:
    """Of the distance v²/2μg."""
    expected = run.factor("speed") ** 2 / (2 * run.factor("mu") * G)
    return abs(float(run["block"].position[-1, 0]) / expected - 1)


def holds(run: Run) -> bool:
    """The incline is less than the angle of friction."""
    return run.factor("angle") < atan(0.5)


def slides(run: Run) -> bool:
    """The incline is more than the angle of friction."""
    return not holds(run)


def slipped(run: Run) -> float:
    """How far down the incline the box went, m."""
    angle, place = run.factor("angle"), run["block"].position
    return float((place[-1] - place[0]) @ [cos(angle), 0, -sin(angle)])


def crept(run: Run) -> float:
    """The way of a box that should stay, m."""
    return abs(slipped(run))


def slid_down(run: Run) -> float:
    """Of the way g (sin α − μ cos α) t²/2."""
    angle, t = run.factor("angle"), run.trace.time[-1]
    return abs(slipped(run) / (G * (sin(angle) - 0.5 * cos(angle)) * t**2 / 2) - 1)


def apex(run: Run) -> float:
    """Height e²h of the highest point after the first impact, as a share of the drop h."""
    e, drop, ball = run.factor("e"), run.factor("drop"), run["ball"]
    after = run.trace.time > sqrt(2 * drop / G) + 0.01
    top = int(ball.position[after, 2].argmax())
    between = ball.velocity[after][top, 2] ** 2 / (2 * G)  # from that sample to the apex between two of them
    return float(abs(ball.position[after][top, 2] + between - 0.05 - e**2 * drop) / drop)


def velocities(run: Run) -> float:
    """Of the speed before: v (m₁ − e m₂)/M and v (1 + e) m₁/M after, with M = m₁ + m₂."""
    m1, m2, e = (run.factor(name) for name in ("m1", "m2", "e"))
    after = np.array([run[name].velocity[-1, 0] for name in ("one", "two")])
    expected = 2 * np.array([m1 - e * m2, (1 + e) * m1]) / (m1 + m2)
    return float(np.abs(after - expected).max() / 2)


def elastic(run: Run) -> bool:
    """Nothing is lost in an impact."""
    return run.factor("e") == 1


def caromed(run: Run) -> float:
    """Of the speed v before: (2 − 5μ) v/7 and (5 − 5μ) v/7 in the end.

    The first stops and keeps its spin, the second goes off without any; then both slide until they roll. The friction
    μ between them takes 5μ v/2r off both spins.
    """
    mu = 0.001
    after = np.array([run[name].velocity[-1, 0] for name in ("one", "two")])
    expected = 2 * (np.array([2, 5]) - 5 * mu) / 7
    return float(np.abs(after - expected).max() / 2)


def frictionless(run: Run) -> bool:
    """Nothing rubs."""
    return run.factor("mu") == 0


def off_axis(run: Run) -> float:
    """How far the struck ball leaves the line of symmetry, m."""
    return float(np.abs(run["third"].position[:, 1]).max())


def struck(run: Run) -> float:
    """Of the speed 2 v c (1 + e)/(1 + 2 c²) of the struck ball, with c the cosine of the angle at which it is hit."""
    place, e = run["one"].position[0], run.factor("e")
    c = abs(place[0]) / np.hypot(place[0], place[1])
    expected = 2 * 2 * c * (1 + e) / (1 + 2 * c**2)
    return float(abs(run["third"].velocity[-1, 0] / expected - 1))


def rolls(run: Run) -> bool:
    """The ball sets off rolling."""
    return bool(run.factors["rolling"])


def sets_off_sliding(run: Run) -> bool:
    """The ball sets off without spin."""
    return not rolls(run)


def kept_speed(run: Run) -> float:
    """Of the speed after 5 s: that of the beginning, or 5/7 of it."""
    return abs(float(run["ball"].velocity[-1, 0]) / (1 if rolls(run) else 5 / 7) - 1)


def threshold(runs: Runs) -> float:
    """Between the last angle at which the box stands and the first at which it falls, rad from atan(1/3)."""
    stood = [run.factor("angle") for run in runs if not fell(run)]
    fallen = [run.factor("angle") for run in runs if fell(run)]
    if not stood or not fallen or max(stood) > min(fallen):
        return radians(90)
    return abs((max(stood) + min(fallen)) / 2 - atan(1 / 3))


def fell(run: Run) -> bool:
    """The box is more than 45 degrees from where it stood."""
    up = rotate(run["tower"].orientation[-1], np.array([0.0, 0.0, 1.0]))
    return bool(up[2] < cos(radians(45)))


def drifted(run: Run) -> float:
    """The largest distance moved by a body that should rest, m."""
    return max(float(np.linalg.norm(m.position[-1] - m.position[0])) for m in run.moving)


def period(run: Run) -> float:
    """Of the period 2π √(I/mgd)/M(1, cos(θ/2)), with M the arithmetic-geometric mean and θ the amplitude.

    Measured from the first passage of the vertical to the last. Source: Carvalhaes and Suppes, Am. J. Phys. 76
    (2008) 1150.
    """
    bar, t, arm = run["bar"], run.trace.time, 0.3
    side = rotate(bar.orientation, np.array([0.0, 0.0, 1.0]))[:, 0]
    before = np.flatnonzero(np.diff(np.sign(side)))
    passages = t[before] + side[before] / (side[before] - side[before + 1]) * (t[1] - t[0])
    measured = 2 * (passages[-1] - passages[0]) / (len(passages) - 1)
    inertia = (0.04**2 + 0.6**2) / 12 + arm**2
    expected = 2 * pi * sqrt(inertia / (G * arm)) / agm(1, cos(run.factor("amplitude") / 2))
    return float(abs(measured / expected - 1))


def agm(a: float, b: float) -> float:
    """The arithmetic-geometric mean."""
    for _ in range(10):  # each doubles the digits that are right
        a, b = (a + b) / 2, sqrt(a * b)
    return a


def gentle(run: Run) -> bool:
    """The pusher is not faster than half a metre a second."""
    return run.factor("speed") <= 0.5


def brisk(run: Run) -> bool:
    """The pusher is faster than that."""
    return not gentle(run)


def pushed(run: Run) -> float:
    """Of the way 0.19 m + v²/2μg, m."""
    expected = 0.19 + run.factor("speed") ** 2 / (2 * run.factor("mu") * G)
    return abs(float(run["block"].position[-1, 0]) - expected)
