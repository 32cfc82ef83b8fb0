"""The episode in MuJoCo's own form."""

from __future__ import annotations

from wmspec.backends.mujoco.execute import STEPS_PER_SECOND, damping
from wmspec.backends.mujoco.mjcf import mjcf
from wmspec.backends.mujoco.world import HEAVY, World
from wmspec.scene.model import Scene
from wmspec.scene.script import script
from wmspec.scene.timeline import episode
from wmspec.scene.validate import validate

WORLD = """model = mujoco.MjModel.from_xml_path(str(Path(__file__).with_name("scene.xml")))
world = World(model, DAMPING)"""


def native(scene: Scene) -> dict[str, str]:
    """`scene.xml`, which MuJoCo's viewer opens, and `run.py`, which plays the actions: file name -> text.

    Raises WmsError for a scene that MuJoCo can't honour.
    """
    validate(scene)
    timeline = episode(scene, STEPS_PER_SECOND)
    values = {"HEAVY": HEAVY, "DAMPING": damping(scene), "EPISODE": timeline}
    run = script("MuJoCo", "mujoco", scene, parts=[World], values=values, world=WORLD)
    return {"scene.xml": mjcf(scene, timeline), "run.py": run}
