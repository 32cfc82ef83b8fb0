"""Tests one engine. Run `python -m wmspec.runtime.doctor.probe ENGINE execute|render`.

The last line of its output is `found: ` with the result, or `failed: ` with a `Failure` as JSON.

`python -m wmspec.runtime.doctor.probe mitsuba photo` tests the renderer of the look "photo".

It is a separate process, because a broken graphics driver may kill the process.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.core.crash import Crash
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.doctor.install_hints import Cause, recognised
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Body, Camera, Geom, Light, Pose, Scene, Shot, Surface
from wmspec.sim.scene.model.transform import identity
from wmspec.sim.scene.physics.inertia import inertia
from wmspec.sim.scene.render.camera import look_at
from wmspec.sim.shapes import Box

GRAVITY = 9.81
SIZE = 64
FOUND, FAILED = "found: ", "failed: "


@dataclass(frozen=True)
class Failure:
    """The failure of a trial: a message, the recognised cause, or else how to report it."""

    words: str
    cause: Cause | None = None
    report: str = ""

    @classmethod
    def of(cls, error: Exception) -> Failure:
        """Return the failure of an exception."""
        words = " ".join(str(error).split())
        if cause := recognised(error):
            return cls(words, cause)
        crash = Crash.of(error)
        kind = "" if isinstance(error, WmsError) else f"{type(error).__name__}: "
        return cls(kind + words, report=crash.advice(crash.save()))

    @classmethod
    def read(cls, text: str) -> Failure:
        """Return a printed failure."""
        values = json.loads(text)
        return cls(values["words"], Cause(**values["cause"]) if values["cause"] else None, values["report"])


def falling_cube() -> Scene:
    """Return a red cube in free fall for 0.1 s, with a camera that looks at its start."""
    shape = Box((0.05,) * 3)
    cube = Body(
        name="cube",
        path="/World/cube",
        motion="dynamic",
        pose=Pose(np.array([0.0, 0.0, 1.0]), identity().orientation),
        geoms=(Geom("shape", shape, identity(), Surface((0.9, 0.1, 0.1))),),
        inertia=inertia([(shape, identity(), 1.0)]),
        linear_velocity=np.zeros(3),
        angular_velocity=np.zeros(3),
    )
    camera = Camera("eye", look_at((0.0, -0.6, 1.1), (0.0, 0.0, 1.0)), math.radians(40), 0.05, 5.0)
    down = np.array([0.0, 0.0, -1.0])
    return Scene("probe", GRAVITY * down, (cube,), (), (camera,), Light(down), (1.0, 1.0, 1.0), (), 0.1)


def execute(engine: str) -> str:
    """Drop the cube. Raises WmsError unless it falls g t² / 2 within 3 %, more than any integrator's error."""
    trace = backend(engine).execute(falling_cube())
    time = float(trace.time[-1])
    fallen = float(trace.position[0, 0, 2] - trace.position[-1, 0, 2])
    expected = GRAVITY * time**2 / 2
    if not (time > 0.05 and abs(fallen / expected - 1) < 0.03):
        raise WmsError(f"a cube fell {1e3 * fallen:.1f} mm in {time:.2f} s; it should be {1e3 * expected:.1f} mm")
    return f"a cube fell {1e3 * fallen:.1f} mm in {time:.2f} s"


def photo(_: str = "") -> str:
    """Render the cube in the look "photo". Raises WmsError unless the centre of the picture is red."""
    from wmspec.sim.photo.library import variant
    from wmspec.sim.photo.tracer import Tracer

    scene = falling_cube()
    rgb = Tracer(scene, (SIZE, SIZE)).draw(Shot("eye", tuple(b.pose for b in scene.bodies)))
    _red(rgb)
    return f"a red cube, by {variant()}"


def render(engine: str) -> str:
    """Render the cube. Raises WmsError unless its mask and a red centre of the picture show it."""
    scene = falling_cube()
    renderer = backend(engine).renderer(scene, SIZE, SIZE)
    frame = renderer.draw(Shot("eye", tuple(b.pose for b in scene.bodies)))
    renderer.close()
    _red(frame.rgb)
    if frame.ids[SIZE // 2, SIZE // 2] != 0:
        raise WmsError("the mask of a red cube does not show it")
    return f"a red cube of {int((frame.ids == 0).sum())} px"


def _red(rgb: NDArray[np.uint8]) -> None:
    red, green, _ = (int(c) for c in rgb[SIZE // 2, SIZE // 2])
    if red < green + 50:
        raise WmsError("the picture of a red cube does not show it")


TRIALS: dict[str, Callable[[str], str]] = {"execute": execute, "render": render, "photo": photo}


def main(engine: str, trial: str) -> int:
    """Print what was found, or what failed; return the exit code 0 or 1."""
    try:
        report, code = FOUND + TRIALS[trial](engine), 0
    except Exception as error:  # noqa: BLE001  whatever an engine raises is what we came to hear
        report, code = FAILED + json.dumps(asdict(Failure.of(error))), 1
    print("\n" + report, flush=True)
    return code


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
