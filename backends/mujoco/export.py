"""Native output for MuJoCo."""

from __future__ import annotations

from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.script import episode_script

from . import clearance
from .mjcf import mjcf
from .physics import prepare
from .world import World, rates, warning_text

WORLD = """model = mujoco.MjModel.from_xml_path(str(Path(__file__).with_name("scene.xml")))
world = World(model, ASSEMBLY)"""


def native(scene: Scene) -> dict[str, str]:
    """Return `scene.xml`, which MuJoCo's viewer opens, and `run.py`, which executes the actions: file name -> text.

    Raises WmsError for a scene that MuJoCo does not support.
    """
    whole, timeline = prepare(scene)
    values = {"ASSEMBLY": whole, "EPISODE": timeline}
    parts = (warning_text, rates, clearance, World)
    run = episode_script("MuJoCo", "mujoco", scene, parts=parts, values=values, world=WORLD)
    return {"scene.xml": mjcf(scene, timeline, whole), "run.py": run}
