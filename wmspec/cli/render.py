"""`wmspec render`: render an instance, a stage or a trace as pictures or a film."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmspec.cli.common import (
    exit_if_failed,
    instance_options,
    load_instance,
    look_options,
    make_folder,
    parse_size,
    size_option,
)
from wmspec.cli.run import duration_option, parse_duration, print_notes
from wmspec.core.crash import Crash
from wmspec.core.diagnostics import EngineError, GraphicsError, StageError, WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import writing
from wmspec.core.tally import Tally
from wmspec.lang.check.tables.vocabulary import STAGES

if TYPE_CHECKING:
    from PIL.Image import Image

    from wmspec.api import Episode, RenderOptions

FILM_SUFFIXES = (".gif", ".mp4")


@click.command("render")
@click.argument("source", type=click.Path(path_type=Path), metavar="SPEC|STAGE|TRACE")
@click.option(
    "--backend",
    "-b",
    default="",
    help="Engines that execute: comma-separated names, or all.  [default: first installed]",
)
@click.option("--renderer", "-r", default="", help="Engine that draws, if different from the executing one.")
@instance_options
@duration_option
@size_option
@look_options
@click.option("--camera", default="", help="Only this camera.  [default: observing cameras; the first one for a film]")
@click.option(
    "--rate", type=click.FloatRange(1, 100), default=25.0, show_default=True, help="Frames per second of a film."
)
@click.option("--overlay", is_flag=True, help="Draw object names and paths.")
@click.option(
    "--output",
    "-o",
    type=click.Path(path_type=Path),
    required=True,
    help="Folder for one PNG per camera and time, or a file: .png for a contact sheet, .gif or .mp4 for a film.",
)
def render_command(
    source: Path,
    backend: str,
    renderer: str,
    task: str,
    instance: int,
    redraw: int,
    seed: int,
    duration: str,
    size: str,
    look: Any,
    samples: int | None,
    camera: str,
    rate: float,
    overlay: bool,
    output: Path,
) -> None:
    """Render the cameras of an instance, of a USD stage, or of a trace written by `wmspec run -o`.

    If an engine refuses or fails, pictures of the others are written; the exit code is then 1.
    """
    from wmspec.api.rendering import renderer_of

    drawing: RenderOptions = {"size": parse_size(size), "renderer": renderer, "look": look, "samples": samples}
    seconds = parse_duration(duration) if duration else None
    executions = _executions(source, backend, task, instance, seed, redraw, seconds)
    many = len(executions) > 1 or backend == "all"
    drawn, causes = 0, list[str]()
    for execute in executions:
        with _record_failure(causes) if len(executions) > 1 else nullcontext():
            episode = execute()
            renderer_of(episode.engine, **drawing)  # fails before a folder is created
            name = f"{episode.scene.name.rpartition('/')[2]}-{instance:06d}-{episode.engine}"
            for path in _write(_Pictures(episode, camera, overlay, drawing), output, name, rate, many):
                click.echo(path)
                drawn += 1
    cause = "\n".join(causes[:1])
    exit_if_failed(
        Tally("picture was drawn", drawn, "engines", len(executions), len(causes), cause, how="failed", most=0)
    )


@contextmanager
def _record_failure(causes: list[str]) -> Iterator[None]:
    """Record why one of several engines cannot execute or draw; raise mistakes of the user."""
    try:
        yield
    except (StageError, EngineError, GraphicsError) as error:
        causes.append(str(error))
    except (WmsError, OSError):
        raise
    except Exception as error:  # noqa: BLE001  the other engines still draw
        causes.append(Crash.of(error).report())


@dataclass(frozen=True)
class _Pictures:
    """An episode and its render options."""

    episode: Episode
    camera: str
    overlay: bool
    drawing: RenderOptions


def _executions(
    source: Path, backend: str, task: str, instance: int, seed: int, redraw: int, seconds: float | None
) -> list[Callable[[], Episode]]:
    """Return functions that give the episodes: one per engine, or one for a stored trace."""
    from wmspec.api import load_episode, open_stage
    from wmspec.api.episode import execute
    from wmspec.runtime.engines.registry import select_backends

    suffix = source.suffix.lower()
    if suffix == ".npz":
        return [partial(load_episode, source)]
    given = suffix in STAGES
    stage = open_stage(source) if given else load_instance(source, task, instance, seed, redraw).stage()

    def executed(engine: str) -> Episode:
        episode = execute(stage, engine, seconds, strict=not given)
        print_notes([episode])
        return episode

    return [partial(executed, engine) for engine in select_backends(backend)]


def _write(pictures: _Pictures, output: Path, name: str, rate: float, many: bool) -> Iterator[Path]:
    """Write the format of the output's suffix; with several engines, one file each."""
    episode, camera = pictures.episode, pictures.camera
    suffix = output.suffix.lower()
    if suffix not in (*FILM_SUFFIXES, ".png"):
        if suffix and not output.is_dir():
            raise WmsError("expected a folder, or a file that ends in .png, .gif or .mp4", FilePlace(str(output)))
        yield from _write_stills(pictures, make_folder(output), name)
        return
    path = output.with_stem(f"{output.stem}-{episode.engine}") if many else output
    make_folder(path.parent)
    if suffix == ".png":
        _save(episode.sheet(camera, overlay=pictures.overlay, **pictures.drawing), path)
    else:
        episode.film(path, camera, rate=rate, overlay=pictures.overlay, **pictures.drawing)
    yield path


def _write_stills(pictures: _Pictures, folder: Path, name: str) -> Iterator[Path]:
    episode = pictures.episode
    for camera, time in episode.views(pictures.camera):
        picture = episode.picture(camera, time, overlay=pictures.overlay, **pictures.drawing)
        yield _save(picture, folder / f"{name}-{camera}-{time:.3f}s.png")


def _save(picture: Image, path: Path) -> Path:
    with writing(path):
        picture.save(path)
    return path
