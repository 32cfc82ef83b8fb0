"""The episode in MuJoCo's own form."""

from __future__ import annotations

from wmspec.sim.scene.joints.articulations import Gear, Link, Tie
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics.rigid import Assembly, Piece, Rigid
from wmspec.sim.scene.script import script

from .clearance import CLEAR, beside, between
from .mjcf import mjcf
from .physics import prepare
from .world import HEAVY, World, rates

WORLD = """model = mujoco.MjModel.from_xml_path(str(Path(__file__).with_name("scene.xml")))
world = World(model, ASSEMBLY)"""


def native(scene: Scene) -> dict[str, str]:
    """`scene.xml`, which MuJoCo's viewer opens, and `run.py`, which plays the actions: file name -> text.

    Raises WmsError for a scene that MuJoCo can't honour.
    """
    whole, timeline = prepare(scene)
    values = {"HEAVY": HEAVY, "CLEAR": CLEAR, "ASSEMBLY": whole, "EPISODE": timeline}
    run = script(
        "MuJoCo",
        "mujoco",
        scene,
        parts=[Piece, Rigid, Link, Tie, Gear, Assembly, rates, between, beside, World],
        values=values,
        world=WORLD,
    )
    return {"scene.xml": mjcf(scene, timeline, whole), "run.py": run}
