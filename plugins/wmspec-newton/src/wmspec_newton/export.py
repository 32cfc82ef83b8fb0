"""Native output for Newton."""

from __future__ import annotations

from wmspec.backends.mujoco.impact import constraint_solref
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.script import episode_script

from . import build, world
from .contacts import contacts, limit_gains
from .physics import prepare


def native(scene: Scene) -> dict[str, str]:
    """Return `run.py`: file name -> text. Raises WmsError for a scene that Newton does not support."""
    whole, timeline = prepare(scene)
    values = {
        "ASSEMBLY": whole,
        "EPISODE": timeline,
        "CONTACTS": contacts(whole),
        "LIMITS": limit_gains(whole.step),
        "TIES": constraint_solref(whole.step),
    }
    made = "world = World(ASSEMBLY, EPISODE.grips, CONTACTS, LIMITS, TIES)"
    return {"run.py": episode_script("Newton", "newton", scene, parts=(build, world), values=values, world=made)}
