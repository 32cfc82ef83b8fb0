"""Native output for Newton."""

from __future__ import annotations

from wmspec.sim.scene.joints.articulations import Link, LoopClosure, MimicConstraint
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics.rigid import Assembly, CollisionShape, Rigid
from wmspec.sim.scene.script import episode_script

from . import build
from .contacts import constraint_solref, contacts, limit_gains
from .physics import prepare
from .world import MOST_DENSE, NEVER, XYZW, World, options

PARTS = (
    *(CollisionShape, Rigid, Link, LoopClosure, MimicConstraint, Assembly),
    build.Built,
    *(build.build, build.add_link, build.add_joint, build.add_shape, build.hull, build.add_pairs),
    *(build.compose, build.transform),
    options,
    World,
)


def native(scene: Scene) -> dict[str, str]:
    """Return `run.py`: file name -> text. Raises WmsError for a scene that Newton does not support."""
    whole, timeline = prepare(scene)
    values = {
        "HEAVY": build.HEAVY,
        "WORLD": build.WORLD,
        "XYZW": XYZW,
        "MOST_DENSE": MOST_DENSE,
        "NEVER": NEVER,
        "ASSEMBLY": whole,
        "EPISODE": timeline,
        "CONTACTS": contacts(whole),
        "LIMITS": limit_gains(whole.step),
        "TIES": constraint_solref(whole.step),
    }
    made = "world = World(ASSEMBLY, EPISODE.grips, CONTACTS, LIMITS, TIES)"
    return {"run.py": episode_script("Newton", "newton", scene, parts=PARTS, values=values, world=made)}
