"""Toy: bodies in free flight, and a rasteriser of a page. An engine of one's own begins as a copy of this."""

from __future__ import annotations

from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.backend import Info
from wmspec.sim.scene.capability import JOINTS, Lack, require
from wmspec.sim.scene.model import Renderer, Scene, Trace

info = Info(
    name="toy",
    title="Toy",
    module="wmspec_toy.world",
    distribution="wmspec-toy",
    requirement="wmspec-toy",
    steps_per_second=1920,
    lacks=(Lack(JOINTS, "Toy knows free bodies only; remove the joint"),),
)


def execute(scene: Scene) -> Trace:
    """The trace of the episode. Raises WmsError for joints, EngineError where two bodies meet."""
    from wmspec.sim.scene.physics.episode import play
    from wmspec.sim.scene.physics.timeline import episode
    from wmspec.sim.scene.physics.to_trace import trace
    from wmspec.sim.scene.validate import validate

    from .world import World

    validate(scene)
    require(info.lacks, scene)
    timeline = episode(scene, info.steps_per_second)
    return trace(info.name, scene, timeline, play(World(scene, timeline.step), timeline))


def renderer(scene: Scene, width: int, height: int) -> Renderer:
    """Make a renderer."""
    from .render import Painter

    return Painter(scene, width, height)


def native(scene: Scene) -> dict[str, str]:
    """Raises WmsError: Toy is read from scenes alone."""
    raise WmsError(f"Toy has no form of its own for {scene.name}; compile it without --backend toy")
