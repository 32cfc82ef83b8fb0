"""Draw the pictures of docs/photo.md: one per kind of task, in the look `photo`.

python tools/photo.py [NAME ...]      docs/images/photo/*.jpg; prints the processor time of each
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path

import wmspec

IMAGES = Path(__file__).parent.parent / "docs/images/photo"
SIDE, SAMPLES = 512, 8


@dataclass(frozen=True)
class View:
    """A view of an instance of a spec's last task: camera (by the end of its name) and time (s)."""

    spec: str
    instance: int
    camera: str
    time: float


VIEWS = {
    "color": View("perception/vision/color", 101, "side", 0.0),
    "material": View("perception/vision/material_room", 101, "close", 0.0),
    "count": View("perception/quantity/count", 202, "top", 0.0),
    "relation": View("perception/space/relation", 7, "front", 0.0),
    "trajectory": View("perception/motion/trajectory", 101, "top", 1.8),
    "duration": View("perception/time/duration", 202, "front", 1.5),
    "collide": View("prediction/mechanistic/collide", 101, "wide", 1.1),
    "contain": View("prediction/mechanistic/contain", 101, "near", 0.13),
    "domino_row": View("prediction/mechanistic/domino_row", 202, "near", 0.2),
    "arms_push": View("prediction/compositionality/arms_push", 101, "facing", 1.5),
    "drive": View("prediction/mechanistic/drive", 101, "driver", 0.0),
    "walk": View("prediction/mechanistic/walk", 202, "eyes", 0.0),
}


def draw(name: str, view: View) -> float:
    """Write a picture; return the processor time (s)."""
    task = wmspec.load_all(Path("specs") / f"{view.spec}.wms")[-1]
    episode = task[view.instance % len(task)].run("mujoco")
    camera = next(camera for camera, _ in episode.views() if camera.endswith(view.camera))
    began = time.process_time()
    picture = episode.picture(camera, view.time, size=SIDE, look="photo", samples=SAMPLES)
    spent = time.process_time() - began
    IMAGES.mkdir(exist_ok=True)
    picture.save(IMAGES / f"{name}.jpg", quality=88, optimize=True)
    return spent


if __name__ == "__main__":
    for chosen in sys.argv[1:] or VIEWS:
        print(f"{chosen}: {draw(chosen, VIEWS[chosen]):.1f} s", flush=True)
