"""Draw the pictures of docs/worlds.md: every object of the libraries, with and without its name, and every room.

python tools/worlds.py things [NAME ...]    with names; smaller, by each engine: docs/images/things*.jpg
python tools/worlds.py rooms [NAME ...]     from each camera: docs/images/rooms.jpg
python tools/worlds.py town                 the town and the flat, as tasks show them: docs/images/town.jpg
python tools/worlds.py nameless FOLDER KEY [LOOK]   one per picture, shuffled; KEY has the names
python tools/worlds.py parity [all]         differences between engines, as table rows, for every sixth object and
                                            every room, or for all from each camera; and the worst
"""

from __future__ import annotations

import json
import math
import random
import re
import sys
from collections.abc import Iterable, Iterator
from itertools import combinations
from pathlib import Path
from typing import cast

import numpy as np
from PIL import Image

import wmspec
from wmspec.dataset.build import typeset
from wmspec.dataset.build.typeset import Style
from wmspec.lang.parse.files import library_folder, read_source
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.engines.registry import default, names
from wmspec.sim.scene.model import Frame, Look, Scene, Shot
from wmspec.sim.scene.model.bounds import world_box
from wmspec.sim.usd import read

IMAGES = Path(__file__).parent.parent / "docs/images"
LIBRARIES = ("kitchenware", "food", "toys", "household", "furniture")
ROOMS: tuple[str, ...] = ("living_room", "kitchen", "office", "workshop", "nursery", "hall", "terrace", "laboratory")
CAMERAS = ("front", "side", "top", "oblique", "person")
ABREAST, GAP = 8, 4

THING = """
use {library} only [{name}]
object ground {{ shape: box  size: ({0:.4f} m, {0:.4f} m, 10 cm)  color: plaster  at: (0, 0, -5 cm)  fixed: true }}
light sun {{ diffuse: 0.8  ambient: 0.45 }}
object it : {name} {{ on: ground at (0, 0){more} }}
camera near {{ at: ({1:.4f} m, {2:.4f} m, {3:.4f} m)  look_at: ({4:.4f} m, {5:.4f} m, {6:.4f} m)  fov: 30 deg }}
task one : custom {{
  factor only in [1, 2]
  object weight {{ shape: sphere  size: 1 mm  mass: only * 1 g  on: ground at ({0:.4f} m * 0.49, {0:.4f} m * 0.49) }}
  observe near at [0 s]
}}
"""
ROOM = """
use {name}{settings} as here
task one : custom {{
  factor only in [1, 2]
  object weight {{ shape: sphere  size: 1 mm  mass: only * 1 g  on: here.{surface} at (0, 0) }}
  observe here.front at [0 s]
}}
"""

PLACE = """
use {0} as here
camera near {{ at: {1}  look_at: {2}  fov: 70 deg }}
task one : custom {{
  factor only in [1, 2]
  object weight {{ shape: sphere  size: 1 mm  mass: only * 1 g  at: (0, 0, 10 cm) }}
  observe near at [0 s]
}}
"""
PLACES = {
    "street of a town": ("town", "(-2 m, -26 m, 1.7 m)", "(0, 0, 2 m)"),
    "living room of a flat": ("apartment", "(-0.6 m, -0.6 m, 1.6 m)", "(-4 m, -3.5 m, 0.8 m)"),
    "bedroom of a flat": ("apartment", "(-1.2 m, 0.8 m, 1.6 m)", "(-4 m, 3.5 m, 0.7 m)"),
    "kitchen of a flat": ("apartment", "(1.2 m, -0.8 m, 1.6 m)", "(4 m, -3.5 m, 0.8 m)"),
    "study of a flat": ("apartment", "(0.6 m, 0.6 m, 1.6 m)", "(4 m, 3.5 m, 0.8 m)"),
}


def scene(text: str) -> Scene:
    """Return the first instance of a spec."""
    return read(wmspec.load(text=text, tell=lambda _: None)[0].stage())


def templates(library: str) -> list[str]:
    """Return the templates of a library, in order."""
    return re.findall(r"^template (\w+)", (library_folder() / f"{library}.wms").read_text(), re.MULTILINE)


def things() -> dict[str, str]:
    """Return object name -> library."""
    return {name: library for library in LIBRARIES for name in templates(library)}


def thing(name: str, library: str, more: str = "") -> Scene:
    """Return a scene with an object on a floor, and a camera that it fills."""

    def placed(*camera: float) -> Scene:
        return scene(THING.format(*camera, name=name, library=library, more=more))

    still = placed(9, 0, -1, 1, 0, 0, 0)
    it = next(body for body in still.bodies if body.name == "it")
    low, high = world_box([geom for geom in it.geoms if geom.visible], it.pose)
    size = high - low
    rise = math.radians(50 if size[2] < 0.3 * max(size[:2]) else 22)
    away = 0.5 * float(np.linalg.norm(size)) / math.sin(math.radians(15)) * 0.98
    middle, turn = (low + high) / 2, math.radians(28)
    return placed(
        away * 2.5,
        middle[0] + away * math.sin(turn) * math.cos(rise),
        middle[1] - away * math.cos(turn) * math.cos(rise),
        middle[2] + away * math.sin(rise),
        *middle,
    )


def surface(name: str) -> str:
    """Return the object that carries others in a room."""
    text = read_source(library_folder() / f"{name}.wms").text
    return "table" if "object table" in text else "floor"


def room(name: str, settings: str = "") -> Scene:
    """Return the scene of a room without actions."""
    return scene(ROOM.format(name=name, settings=settings, surface=surface(name)))


def frames(what: Scene, engine: str, side: int, cameras: Iterable[str], look: Look = "parity") -> list[Frame]:
    """Return initial frames, from cameras by the ends of their names."""
    studio = RenderCache(engine, side, side, look)
    poses = tuple(body.pose for body in what.bodies)
    views = [next(one.name for one in what.cameras if one.name.endswith(camera)) for camera in cameras]
    drawn = [studio.draw(what, Shot(view, poses), depth=True) for view in views]
    studio.close()
    return drawn


def pictures(
    what: Scene, engine: str, side: int, cameras: Iterable[str] = ("near",), look: Look = "parity"
) -> list[Image.Image]:
    """Return the frames as pictures."""
    return [Image.fromarray(frame.rgb) for frame in frames(what, engine, side, cameras, look)]


def rows(cells: Iterable[Image.Image], abreast: int) -> Iterator[Image.Image]:
    """Yield rows of `abreast` cells."""
    every = list(cells)
    for i in range(0, len(every), abreast):
        yield typeset.hstack(every[i : i + abreast], GAP)


def thing_cell(name: str, library: str, engines: Iterable[str], side: int) -> Image.Image:
    """Return an object in each engine, with its name below."""
    what = thing(name, library)
    cell = typeset.hstack([one for engine in engines for one in pictures(what, engine, side)])
    label = typeset.paragraph(name.replace("_", " "), Style(15), cell.width, centred=True)
    return typeset.vstack([cell, label])


def things_sheet(chosen: Iterable[str], engines: Iterable[str], side: int) -> Image.Image:
    """Return a sheet of all objects."""
    every = things()
    cells = [thing_cell(name, every[name], engines, side) for name in chosen]
    return typeset.pad(typeset.vstack(rows(cells, ABREAST if len(tuple(engines)) == 1 else 5), GAP), GAP)


def rooms_sheet(chosen: Iterable[str], engines: Iterable[str], side: int) -> Image.Image:
    """Return a sheet with a row per room and engine, and a column per camera."""
    lines = []
    for name in chosen:
        for engine in engines:
            label = typeset.paragraph(f"{name.replace('_', ' ')}, {engine}", Style(15), 90)
            shown = pictures(room(name), engine, side, CAMERAS)
            lines.append(typeset.hstack([label, *shown], GAP, middle=True))
    return typeset.pad(typeset.vstack(lines, GAP), GAP)


def town_sheet(side: int, count: int) -> Image.Image:
    """What is seen first in tasks of driving, and below in tasks of walking: instances spread over them."""
    lines = []
    for spec in ("drive", "walk"):
        task = wmspec.load_all(library_folder().parent / f"prediction/mechanistic/{spec}.wms")[-1]
        episodes = [task[i * len(task) // count].run("mujoco") for i in range(count)]
        shown = [episode.picture(*episode.views()[0], size=side) for episode in episodes]
        lines.append(typeset.hstack(shown, GAP))
    return typeset.pad(typeset.vstack(lines, GAP), GAP)


def apart(a: Frame, b: Frame) -> tuple[float, float, float]:
    """Of what both show: least overlap (IoU), most apart in mean colour (of 255), 99th percentile in depth (mm)."""
    overlap, color = 1.0, 0.0
    for body in np.unique(a.ids):
        one, two = a.ids == body, b.ids == body
        if one.sum() < 50:
            continue
        overlap = min(overlap, float((one & two).sum() / (one | two).sum()))
        color = max(color, float(np.abs(a.rgb[one].mean(axis=0) - b.rgb[two].mean(axis=0)).max()))
    assert a.depth is not None
    assert b.depth is not None
    same = (a.ids == b.ids) & (a.ids >= 0)
    return overlap, color, float(np.percentile(np.abs(a.depth - b.depth)[same], 99)) * 1000


def parity(step: int, cameras: Iterable[str], side: int = 256) -> Iterator[str]:
    """The lines of the table: every n-th object, and every room from each camera."""
    every = things()
    sample = [(name, thing(name, every[name]), "near") for name in list(every)[::step]]
    sample += [
        (name if camera == "front" else f"{name}, {camera}", room(name), camera) for name in ROOMS for camera in cameras
    ]
    measured = []
    for name, what, camera in sample:
        drawn = {engine: frames(what, engine, side, [camera])[0] for engine in names()}
        measured.append(worst(apart(drawn[a], drawn[b]) for a, b in combinations(drawn, 2)))
        yield line(name, measured[-1])
    yield line(f"the worst of {len(measured)}", worst(measured))


def worst(measured: Iterable[tuple[float, float, float]]) -> tuple[float, float, float]:
    """The least overlap, and the most apart in colour and in depth."""
    overlap, color, depth = zip(*measured, strict=True)
    return min(overlap), max(color), max(depth)


def line(name: str, measured: tuple[float, float, float]) -> str:
    """A line of the table."""
    overlap, color, depth = measured
    return f"| {name.replace('_', ' ')} | {overlap:.3f} | {color:.1f} | {depth:.3f} |"


def shown(name: str) -> tuple[Scene, str]:
    """A thing, a room or a place, and the camera that it is seen from."""
    if name in PLACES:
        return scene(PLACE.format(*PLACES[name])), "near"
    if name in ROOMS:
        return room(name), "person"
    return thing(name, things()[name]), "near"


def nameless(folder: Path, key: Path, look: Look = "parity", side: int = 320) -> None:
    """Every thing, room and place in a picture of its own, in no order, and what each shows."""
    every = [*things(), *ROOMS, *PLACES]
    random.Random(0).shuffle(every)
    folder.mkdir(parents=True)
    for number, name in enumerate(every):
        what, camera = shown(name)
        pictures(what, default(), side, [camera], look)[0].save(folder / f"{number:03}.png")
    key.write_text(json.dumps({f"{number:03}": name for number, name in enumerate(every)}, indent=1))


def main(kind: str, *chosen: str) -> int:
    """Write a picture, or print the lines."""
    if kind == "parity":
        for line in parity(1, CAMERAS) if chosen else parity(6, ("front",)):
            print(line, flush=True)
        return 0
    if kind == "nameless":
        folder, key, *look = chosen
        nameless(Path(folder), Path(key), cast(Look, look[0]) if look else "parity")
        return 0
    if kind == "rooms":
        rooms_sheet(chosen or ROOMS, (default(),), 240).save(IMAGES / "rooms.jpg", quality=85)
        return 0
    if kind == "town":
        town_sheet(240, 5).save(IMAGES / "town.jpg", quality=88)
        return 0
    every = chosen or tuple(things())
    things_sheet(every, (default(),), 160).save(IMAGES / "things.jpg", quality=85)
    things_sheet(every, names(), 104).save(IMAGES / "things_engines.jpg", quality=85)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
