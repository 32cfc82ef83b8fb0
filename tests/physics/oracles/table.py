"""Error limits of each engine, which the tests enforce and `tools/oracles.py` writes to docs/benchmarks/oracles.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tests.physics.oracles import answers as of
from tests.physics.oracles.runs import runs

MEASURED = ("mujoco", "pybullet", "sapien", "newton")
UNITS = {"mm": 1000.0, "%": 100.0, "deg": 57.29577951308232}


@dataclass(frozen=True)
class Oracle:
    """An analytic answer: the spec whose episodes are compared with it, how, in which unit, and the bar of each engine.

    Bars are in the order of `MEASURED`, each with the digits that count: an engine meets its bar if the error, rounded
    to them, is not above it.
    """

    spec: str
    what: str
    answer: str
    unit: str
    error: Callable[[of.Runs], float]
    bars: str

    def measure(self, engine: str) -> float:
        """The worst error in an engine, in `unit`."""
        return self.error(runs(self.spec, engine)) * UNITS[self.unit]

    def bar(self, engine: str) -> str:
        """The most that an engine may be off, in `unit`; one that has no bar yet, as much as any other."""
        bars = dict(zip(MEASURED, self.bars.split(), strict=True))
        return bars.get(engine) or max(bars.values(), key=float)

    def meets(self, engine: str, error: float) -> bool:
        """Whether an error of an engine, in `unit`, is within its bar."""
        _, _, digits = self.bar(engine).partition(".")
        return round(error, len(digits)) <= float(self.bar(engine))


worst = of.worst

ORACLES = (
    Oracle("flight", "position in free flight, 1 s", "p + vt + gt²/2", "mm",
           worst(of.off_parabola), "0.000 0.000 0.020 0.120"),
    Oracle("flight", "energy in free flight", "constant", "%", worst(of.falling_energy), "0.03 0.06 0.06 0.06"),
    Oracle("slide", "stopping distance of a sliding box", "v²/2μg", "%", worst(of.stopping), "0.07 0.15 0.17 0.07"),
    Oracle("incline", "creep in 2 s, on an incline below the friction angle", "0", "mm",
           worst(of.crept, of.holds), "0.00 0.00 0.30 0.00"),
    Oracle("incline", "distance slid in 2 s, on an incline above the friction angle", "g(sin α − μ cos α)t²/2", "%",
           worst(of.slid_down, of.slides), "0.1 0.1 0.1 0.1"),
    Oracle("tip", "angle of an incline at which a box tips", "atan(b/h)", "deg",
           of.threshold, "0.01 0.01 0.01 0.01"),
    Oracle("bounce", "height of a bounce, relative to the drop height h", "e²h", "%",
           worst(of.apex), "2.2 0.7 0.2 2.2"),
    Oracle("collide", "speeds after a frictionless collision, relative to v", "v(m₁ − em₂)/M, v(1 + e)m₁/M", "%",
           worst(of.velocities), "1.15 0.00 0.00 1.15"),
    Oracle("collide", "momentum in this collision", "constant", "%", worst(of.lost_momentum), "0.00 0.00 0.00 0.00"),
    Oracle("collide", "energy in this collision, e = 1", "constant", "%",
           worst(of.changed_energy, of.elastic), "1.00 0.00 0.00 1.00"),
    Oracle("carom", "speeds after a collision of rolling balls, relative to v", "2v/7, 5v/7", "%",
           worst(of.caromed), "2.6 0.10 0.13 2.6"),
    Oracle("third", "ball struck by two at once: distance from the symmetry axis", "0", "mm",
           worst(of.off_axis), "0.0 0.0 1.7 0.0"),
    Oracle("third", "ball struck by two at once: its speed", "2vc(1 + e)/(1 + 2c²)", "%",
           worst(of.struck, of.frictionless), "1.5 0.0 0.0 1.5"),
    Oracle("glance", "momentum in an off-centre collision of boxes", "constant", "%",
           worst(of.lost_momentum), "0.00 0.00 0.00 0.00"),
    Oracle("glance", "angular momentum in this collision of boxes", "constant", "%",
           worst(of.lost_angular_momentum), "0.00 0.09 0.07 0.00"),
    Oracle("glance", "energy in this collision of boxes", "no gain", "%",
           worst(of.gained_energy), "0.00 0.00 0.00 0.00"),
    Oracle("roll", "speed after 5 s of a rolling ball", "v", "%",
           worst(of.kept_speed, of.rolls), "0.00 0.00 0.06 0.00"),
    Oracle("roll", "speed after 5 s of a ball that starts without spin", "5v/7", "%",
           worst(of.kept_speed, of.sets_off_sliding), "0.00 0.00 0.09 0.00"),
    Oracle("pendulum", "period of a pendulum", "2π√(I/mgd)/M(1, cos(θ/2))", "%",
           worst(of.period), "0.0001 0.0001 0.004 0.0001"),
    Oracle("stack", "drift in 5 s of a stack of five cubes", "0", "mm", worst(of.drifted), "0.00 0.11 0.00 0.00"),
    Oracle("pusher", "distance of a box pushed at up to 0.5 m/s", "d + v²/2μg", "mm",
           worst(of.pushed, of.gentle), "4.9 0.3 0.2 0.6"),
    Oracle("pusher", "distance of a box pushed at 1 m/s", "d + v²/2μg", "mm",
           worst(of.pushed, of.brisk), "4.9 0.3 0.3 7.5"),
)  # fmt: skip
