"""A USD stage as a `Scene`: everything that an engine is given, in metres, kilograms, seconds and Z up."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:  # who needs a name of this package alone, such as the version of the format, should not wait for USD
    from pxr import Usd

    from wmspec.sim.scene.model import Scene


def read(stage: Usd.Stage, *, strict: bool = True) -> Scene:
    """Read a stage: ours, or anyone's standard UsdPhysics.

    A stage without a WmsEpisode lasts 0 s: `dataclasses.replace(scene, duration=...)`. One without cameras gets one
    named 'overview', one without lights the default light.

    Unless it is `strict`, what only shows and cannot be drawn, and what can be executed nearly as it is meant, has a
    stand-in, which the scene's `notes` tell.

    Raises:
        StageError: with everything on the stage that is wrong or not supported, each with its prim and remedy.
    """
    from pxr import Tf

    from wmspec.core.diagnostics import StageError
    from wmspec.sim.usd.files import text_of
    from wmspec.sim.usd.scene import scene
    from wmspec.sim.usd.substitutions import Notes

    try:
        return scene(stage, Notes(strict=strict))
    except TypeError as error:  # of pxr: an attribute with the name of one of a schema has a value of another type
        reason = str(error).splitlines()[0][:200]
        raise StageError(f"an attribute has a value of another type than its schema says ({reason})") from error
    except Tf.ErrorException as error:  # what USD itself finds wrong with a value, when it is asked for
        complaint = text_of(error).partition(" : '")[2].partition("'\n")[0]
        raise StageError(complaint[:300] or "it is damaged", help="export it again") from error
