"""Reads a USD stage as a `Scene`: everything that an engine receives, in metres, kilograms, seconds and Z up."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:  # importing this package for `FORMAT_VERSION` must not load USD
    from pxr import Usd

    from wmspec.sim.scene.model import Scene


def read(stage: Usd.Stage, *, strict: bool = True) -> Scene:
    """Read a stage: one of wmspec, or any standard UsdPhysics stage.

    A stage without a WmsEpisode has duration 0: use `dataclasses.replace(scene, duration=...)`. A stage without cameras
    gets one named 'overview', a stage without lights the default light.

    Unless `strict`, unsupported visuals and features that can be approximated get a stand-in, listed in `notes` of the
    scene.

    Raises: StageError: with all errors and unsupported features of the stage, each with prim and remedy.
    """
    from pxr import Tf

    from wmspec.core.diagnostics import StageError
    from wmspec.sim.usd.files import complaint
    from wmspec.sim.usd.scene import scene
    from wmspec.sim.usd.substitutions import Substitutions

    try:
        return scene(stage, Substitutions(strict=strict))
    except TypeError as error:  # from pxr: the value of an attribute has another type than its schema
        reason = str(error).splitlines()[0][:200]
        raise StageError(f"the value of an attribute has another type than its schema ({reason})") from error
    except Tf.ErrorException as error:  # USD reports invalid values when they are read
        raise StageError(complaint(error), help="export it again") from error
