"""Draw the picture of docs/pixels.md: every environment in every look and engine.

python tools/pixels.py [OUTPUT]
"""

from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image

from tools.worlds import scene
from wmspec.dataset.build import typeset
from wmspec.dataset.build.typeset import Style
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.engines.registry import info, names
from wmspec.sim.scene.model import Look, Scene, Shot

OUTPUT = Path(__file__).parent.parent / "docs/images/pixels.jpg"
PLACES = {
    "tabletop": "table",
    "tabletop_cool": "table",
    "tabletop_dark": "table",
    "room": "floor",
    "room_cool": "floor",
    "room_dark": "floor",
    "floor": "floor",
}
"""Environment -> the object that carries others there."""

LOOKS: tuple[tuple[str, Look], ...] = (*((name, "parity") for name in names() if info(name).draws), ("mujoco", "photo"))
CAMERA, SIDE = "oblique", 256

STILL = """
use {place}
task still : custom {{
  factor only in [1, 2]
  object can   {{ shape: cylinder  size: 11 cm  color: white   material: marble  on: {ground} at (-22 cm, 9 cm) }}
  object dice  {{
    shape: cube  size: 11 cm  color: blue  material: rubber  on: {ground} at (-3 cm, 13 cm)  yaw: 25 deg
  }}
  object ball  {{ shape: sphere    size: 13 cm  color: red     on: {ground} at (18 cm, 8 cm)  mass: only * 1 kg }}
  object hat   {{ shape: cone      size: 13 cm  color: orange  material: wood    on: {ground} at (-20 cm, -12 cm) }}
  object steel {{ shape: sphere    size: 11 cm  material: metal  on: {ground} at (-1 cm, -7 cm) }}
  object block {{
    shape: cube  size: 10 cm  color: yellow  material: checker  on: {ground} at (19 cm, -13 cm)  yaw: 40 deg
  }}
  observe {camera} at [0 s]
}}
"""


def picture(what: Scene, engine: str, look: Look) -> Image.Image:
    """Return a picture of the initial scene."""
    studio = RenderCache(engine, SIDE, SIDE, look)
    frame = studio.draw(what, Shot(CAMERA, tuple(body.pose for body in what.bodies)))
    studio.close()
    return Image.fromarray(frame.rgb)


def sheet() -> Image.Image:
    """Return a sheet with a row per environment and a column per engine and look."""
    label, name, wide = Style(20, bold=True), Style(17), 150
    heads = [typeset.paragraph(f"{engine}, {look}", label, SIDE) for engine, look in LOOKS]
    rows = [typeset.hstack([typeset.blank(wide, 1), *heads], 8)]
    for place, ground in PLACES.items():
        what = scene(STILL.format(place=place, ground=ground, camera=CAMERA))
        pictures = [picture(what, *look) for look in LOOKS]
        rows.append(typeset.hstack([typeset.paragraph(place, name, wide), *pictures], 8, middle=True))
        print(place, flush=True)
    return typeset.pad(typeset.vstack(rows, 8), 16)


def main(output: str = str(OUTPUT)) -> int:
    """Write the picture."""
    sheet().save(output, quality=90)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
