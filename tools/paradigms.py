"""Draw the pictures of the paradigms in docs/gallery.md: up to four of what a question shows, side by side.

python tools/paradigms.py [NAME ...]    of these specs in specs/paradigms, or of all
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image

import wmspec

ROOT = Path(__file__).parent.parent
SPECS, PICTURES = ROOT / "specs/paradigms", ROOT / "docs/images/paradigms"
#: Number and side (px) of the pictures of a strip, and the gap between them.
MOST, SIDE, GAP = 4, 200, 6
#: The instance that a strip shows, where the first one shows less.
INSTANCES = {"solidity": 1}


def strip(path: Path) -> Image.Image:
    """Return pictures of an instance, evenly spaced in time, with the first and the last one."""
    episode = wmspec.load(path)[INSTANCES.get(path.stem, 0)].run("mujoco")
    views = episode.views()
    chosen = sorted({round(i) for i in np.linspace(0, len(views) - 1, MOST)})
    whole = Image.new("RGB", (len(chosen) * (SIDE + GAP) - GAP, SIDE), "white")
    for column, number in enumerate(chosen):
        picture = episode.picture(*views[number], size=2 * SIDE).resize((SIDE, SIDE))
        whole.paste(picture, (column * (SIDE + GAP), 0))
    return whole


def main(names: list[str]) -> None:
    """Write the strips of some specs, or of all."""
    PICTURES.mkdir(exist_ok=True)
    for path in sorted(SPECS.glob("*.wms")):
        if not names or path.stem in names:
            strip(path).save(PICTURES / f"{path.stem}.jpg", quality=88)


if __name__ == "__main__":
    main(sys.argv[1:])
