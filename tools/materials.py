"""Draw the materials of docs/pixels.md: each on a ball, a cube and a cylinder, in its own colour and in blue.

python tools/materials.py [OUTPUT]
"""

from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image

from tools.worlds import scene
from wmspec.dataset.build import typeset
from wmspec.dataset.build.typeset import Style
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.engines.registry import default
from wmspec.sim.materials import MATERIALS
from wmspec.sim.scene.model import Look, Shot

OUTPUT = Path(__file__).parent.parent / "docs/images/materials.jpg"
SIDE = 190
ROWS: tuple[tuple[str, str, Look], ...] = (
    ("parity", "", "parity"),
    ("parity, blue", "color: blue", "parity"),
    ("photo", "", "photo"),
)
SPEC = """
use floor
camera near {{ at: (0, -70 cm, 52 cm)  look_at: (0, 0, 4 cm)  fov: 24 deg }}
task one : custom {{
  factor only in [1, 2]
  object ball   {{
    shape: sphere  size: 13 cm  material: {name}  {color}  on: floor at (-7 cm, 7 cm)  mass: only * 1 kg
  }}
  object block  {{ shape: cube      size: 11 cm  material: {name}  {color}  on: floor at (7 cm, 6 cm)  yaw: 20 deg }}
  object drum   {{ shape: cylinder  size: 10 cm  material: {name}  {color}  on: floor at (0, -8 cm) }}
  observe near at [0 s]
}}
"""


def picture(name: str, color: str, look: Look) -> Image.Image:
    """Return a picture of three objects of a material."""
    what = scene(SPEC.format(name=name, color=color))
    studio = RenderCache(default(), SIDE, SIDE, look)
    frame = studio.draw(what, Shot("near", tuple(body.pose for body in what.bodies)))
    studio.close()
    return Image.fromarray(frame.rgb)


def sheet() -> Image.Image:
    """Return rows of seven materials."""
    label, name, wide = Style(18, bold=True), Style(15), 110
    parts, names = [], list(MATERIALS)
    for row in (names[i : i + 7] for i in range(0, len(names), 7)):
        parts.append(typeset.hstack([typeset.blank(wide, 1), *(typeset.paragraph(one, label, SIDE) for one in row)], 6))
        for title, color, look in ROWS:
            pictures = [picture(one, color, look) for one in row]
            parts.append(typeset.hstack([typeset.paragraph(title, name, wide), *pictures], 6, middle=True))
    return typeset.pad(typeset.vstack(parts, 6), 14)


def main(output: str = str(OUTPUT)) -> int:
    """Write the picture."""
    sheet().save(output, quality=90)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
