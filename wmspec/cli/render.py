"""`wmspec render`: pictures of an instance, a stage or a trace, still or in motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from wmspec.cli.common import (
    instance_option,
    look_options,
    make_folder,
    parse_size,
    samples_for,
    seed_option,
)
from wmspec.diagnostics import WmsError

FILMS = (".gif", ".mp4")


@click.command("render")
@click.argument("source", type=click.Path(path_type=Path), metavar="SPEC|STAGE|TRACE")
@click.option(
    "--backend",
    "-b",
    default="",
    help="Engines that execute: names joined by commas, or all.  [default: the first there is]",
)
@click.option("--renderer", "-r", default="", help="The engine that draws, if another than the one that executes.")
@instance_option
@seed_option
@click.option("--size", default="256", show_default=True, help="Pixels: 256, or 320x240.")
@look_options
@click.option("--camera", default="", help="Only this camera.  [default: those that observe; for a film the first]")
@click.option(
    "--rate", type=click.FloatRange(1, 100), default=25.0, show_default=True, help="Pictures a second of a film."
)
@click.option("--overlay", is_flag=True, help="Draw the names of things and the ways they have come.")
@click.option(
    "--output",
    "-o",
    type=click.Path(path_type=Path),
    required=True,
    help="A folder for one PNG per camera and time; or a file: .png for a sheet of them, .gif or .mp4 for a film.",
)
def render_command(
    source: Path,
    backend: str,
    renderer: str,
    instance: int,
    seed: int,
    size: str,
    look: Any,
    samples: int | None,
    camera: str,
    rate: float,
    overlay: bool,
    output: Path,
) -> None:
    """Draw what the cameras of an instance, of a USD stage, or of a trace that `wmspec run -o` wrote, observe."""
    from wmspec.execute.backends import chosen, drawing
    from wmspec.execute.render_cache import RenderCache

    width, height = parse_size(size)
    samples = samples_for(look, samples)
    drawers = drawing(chosen(renderer), look)[:1] if renderer else ()
    for scene, trace in _episodes(source, backend, instance, seed):
        drawer = (drawers or drawing((trace.engine,), look))[0]
        studio = RenderCache(drawer, width, height, look, samples)
        episode = _Episode(scene, trace, studio, overlay, camera)
        name = f"{scene.name}-{instance:06d}-{trace.engine}"
        for path in _written(episode, output, name, rate, many="," in backend or backend == "all"):
            click.echo(path)
        studio.close()


@dataclass(frozen=True)
class _Episode:
    """What happened, and who draws it how."""

    scene: Any
    trace: Any
    studio: Any
    overlay: bool
    camera: str

    def looks(self) -> list[tuple[str, float]]:
        """The cameras and times (s) to draw."""
        from wmspec.scene.camera import find

        seen = [(o.camera, t) for o in self.scene.observations for t in o.times]
        looks = seen or [(c.name, 0.0) for c in self.scene.cameras]
        if not self.camera:
            return looks
        find(self.scene, self.camera)
        times = sorted({t for c, t in looks if c == self.camera} or {t for _, t in looks})
        return [(self.camera, t) for t in times]

    def picture(self, camera: str, time: float) -> Any:
        """What is seen at a time."""
        from PIL import Image

        from wmspec.scene.model import Shot
        from wmspec.write.overlay import annotated

        frame = self.studio.draw(self.scene, Shot(camera, self.trace.poses(time)))
        return annotated(frame, self.scene, self.trace, camera, time) if self.overlay else Image.fromarray(frame.rgb)


def _episodes(source: Path, backend: str, instance: int, seed: int) -> Iterator[tuple[Any, Any]]:
    """The scene and what happened in it, once for each engine that executes it, or as it was written to disk."""
    from wmspec.cli.run import load_stage
    from wmspec.execute.archive import load
    from wmspec.execute.backends import backend as load_backend
    from wmspec.execute.backends import chosen
    from wmspec.usd import read

    if source.suffix.lower() == ".npz":
        yield load(source)
        return
    scene = read(load_stage(source, instance, seed))
    for engine in chosen(backend):
        yield scene, load_backend(engine).execute(scene)


def _written(episode: _Episode, output: Path, name: str, rate: float, many: bool) -> Iterator[Path]:
    """Write what the suffix of the output asks for; with many engines, each to a file of its own."""
    from wmspec.write.film import WRITERS

    suffix = output.suffix.lower()
    if suffix not in (*FILMS, ".png"):
        if suffix and not output.is_dir():
            raise WmsError(f"{output}: expected a folder, or a file that ends in .png, .gif or .mp4")
        yield from _stills(episode, make_folder(output), name)
        return
    path = output.with_stem(f"{output.stem}-{episode.trace.engine}") if many else output
    make_folder(path.parent)
    try:
        if suffix == ".png":
            _sheet(episode).save(path)
        else:
            WRITERS[suffix](_moving(episode, rate), rate, path)
    except OSError as error:
        raise WmsError(f"{path}: cannot be written: {error.strerror or error}") from None
    yield path


def _stills(episode: _Episode, folder: Path, name: str) -> Iterator[Path]:
    for camera, time in episode.looks():
        path = folder / f"{name}-{camera}-{time:.3f}s.png"
        try:
            episode.picture(camera, time).save(path)
        except OSError as error:
            raise WmsError(f"{path}: cannot be written: {error.strerror}") from None
        yield path


def _moving(episode: _Episode, rate: float) -> Iterator[Any]:
    """The whole episode."""
    camera = episode.looks()[0][0]
    for i in range(int(episode.trace.time[-1] * rate + 1e-9) + 1):
        yield episode.picture(camera, i / rate)


def _sheet(episode: _Episode) -> Any:
    """A row for each camera, a picture for each time, with both above it; a single picture as it is."""
    from wmspec.write import typeset
    from wmspec.write.typeset import Style

    looks = episode.looks()
    if len(looks) == 1:
        return episode.picture(*looks[0])
    rows = []
    for camera in dict.fromkeys(camera for camera, _ in looks):
        times = [time for other, time in looks if other == camera]
        shown = [(f"{camera}, {time:.3g} s", episode.picture(camera, time)) for time in times]
        rows.append(typeset.beside([_captioned(said, one, typeset, Style(15)) for said, one in shown], 8))
    return typeset.padded(typeset.above(rows, 12), 12)


def _captioned(said: str, picture: Any, typeset: Any, style: Any) -> Any:
    return typeset.above([typeset.paragraph(said, style, picture.width), picture], 2)
