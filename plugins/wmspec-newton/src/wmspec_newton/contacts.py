"""Contact parameters of Newton's MuJoCo solver, in which contacts are damped springs.

They are those of wmspec's MuJoCo backend, which fits them to analytic impacts.
"""

from __future__ import annotations

from wmspec.backends.mujoco.impact import ROLLING_FRICTION, SOLIMP, TORSIONAL_FRICTION, solref, solreffriction
from wmspec.sim.scene.model import Friction
from wmspec.sim.scene.physics.contact import combine_friction
from wmspec.sim.scene.physics.episode import TOUCH_END, Vector
from wmspec.sim.scene.physics.rigid import Assembly

#: For two materials and whether a kinematic body takes part: the columns of Newton's contact pairs.
Contacts = dict[tuple[Vector, Vector, bool], dict[str, int | float | Vector]]


def contacts(assembly: Assembly) -> Contacts:
    """Return the contact parameters of every two materials that can touch."""
    table: Contacts = {}
    for i, a in enumerate(assembly.bodies):
        for b in assembly.bodies[i + 1 :]:
            if "dynamic" in (a.motion, b.motion):
                led = "kinematic" in (a.motion, b.motion)
                for p, q in {(p.material, q.material) for p in a.pieces for q in b.pieces}:
                    table.setdefault((p, q, led), _parameters(p, q, led, assembly.step))
    return table


def _parameters(p: Vector, q: Vector, led: bool, step: float) -> dict[str, int | float | Vector]:
    pair = combine_friction(Friction(*p), Friction(*q))
    return {
        "condim": 3 if pair.dynamic > 0 else 1,
        "friction": (pair.dynamic, pair.dynamic, TORSIONAL_FRICTION, ROLLING_FRICTION, ROLLING_FRICTION),
        "solref": solref(pair, step),
        "solreffriction": solreffriction(pair, step, led),
        "solimp": SOLIMP,
        "gap": TOUCH_END,  # detected from the margin on, force from 0 on
    }


def limit_gains(step: float) -> Vector:
    """Return the `solref` of joint limits, inelastic."""
    stiffness, damping = solref(Friction(), step)
    return stiffness, damping
