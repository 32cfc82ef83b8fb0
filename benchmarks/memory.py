"""Memory growth of rendering: thousands of frames of one renderer, hundreds of renderers.

python benchmarks/memory.py [--engines A,B,...] [--frames 5000] [--rebuilds 500]
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import math
from pathlib import Path

import numpy as np

from benchmarks.render import body
from wmspec.runtime.engines.registry import backend, names
from wmspec.sim.scene.model import Camera, Light, Pose, Scene, Shot
from wmspec.sim.scene.render.camera import look_at
from wmspec.sim.shapes import Box, Cylinder, Sphere

SIZE, WARM = 64, 20


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--engines", default=",".join(names()))
    parser.add_argument("--frames", type=int, default=5000)
    parser.add_argument("--rebuilds", type=int, default=500)
    chosen = parser.parse_args()
    print(f"{'':<10}{chosen.frames:>8} frames{chosen.rebuilds:>8} rebuilds")
    for engine in chosen.engines.split(","):
        drawn, rebuilt = frames(engine, chosen.frames), rebuilds(engine, chosen.rebuilds)
        print(f"{engine:<10}{drawn:>12.1f} MB{rebuilt:>14.1f} MB")


def frames(engine: str, count: int) -> float:
    """Return the growth of the process (MB) while a renderer draws moving objects."""
    scene = still()
    renderer = backend(engine).renderer(scene, SIZE, SIZE)
    before = 0.0
    for i in range(WARM + count):
        if i == WARM:
            before = resident()
        lift = np.array([0.0, 0.0, 0.05 * math.sin(i)])
        renderer.draw(Shot("eye", [Pose(b.pose.position + lift, b.pose.orientation) for b in scene.bodies]), depth=True)
    grown = resident() - before
    renderer.close()
    return grown


def rebuilds(engine: str, count: int) -> float:
    """Return the growth of the process (MB) while renderers are created, used and closed."""
    scene, before = still(), 0.0
    for i in range(WARM + count):
        if i == WARM:
            before = resident()
        renderer = backend(engine).renderer(scene, SIZE, SIZE)
        renderer.draw(Shot("eye", [body.pose for body in scene.bodies]))
        renderer.close()
    return resident() - before


def still() -> Scene:
    """Return a scene of four objects."""
    shapes = (Box((2.0, 2.0, 0.05)), Sphere(0.06), Cylinder(0.05, 0.12), Box((0.05,) * 3))
    places = ((0, 0, -0.05), (-0.2, 0, 0.06), (0, 0.1, 0.06), (0.2, 0, 0.05))
    bodies = tuple(
        body(f"thing{i}", "dynamic" if i else "static", at, shape, (0.3 + 0.2 * i, 0.5, 0.4))
        for i, (shape, at) in enumerate(zip(shapes, places, strict=True))
    )
    eye = Camera("eye", look_at((0, -1.2, 0.8), (0, 0, 0)), math.radians(40), 0.05, 20.0)
    light = Light(np.array([0.0, 0.6, -0.8]))
    return Scene("still", np.array([0, 0, -9.81]), bodies, (), (eye,), light, (0.8, 0.9, 1.0), (), 1.0)


def resident() -> float:
    """Return the memory of this process in MB, after the allocator is trimmed."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6


if __name__ == "__main__":
    main()
