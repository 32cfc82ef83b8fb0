"""`wmspec render`: pictures of an instance, a stage or a trace, still or in motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmspec.cli.common import (
    instance_of,
    instance_option,
    look_options,
    make_folder,
    parse_size,
    redrawn_option,
    seed_option,
    settle,
    size_option,
    task_option,
)
from wmspec.cli.run import duration_option, seconds_of, tell_notes
from wmspec.core.crash import Crash
from wmspec.core.diagnostics import EngineError, GraphicsError, StageError, WmsError
from wmspec.core.places import FilePlace
from wmspec.core.tally import Tally
from wmspec.lang.check.tables.vocabulary import STAGES

if TYPE_CHECKING:
    from PIL.Image import Image

    from wmspec.api import Drawing, Episode

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
@task_option
@instance_option
@redrawn_option
@seed_option
@duration_option
@size_option
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
    task: str,
    instance: int,
    redrawn: int,
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
    """Draw what the cameras of an instance, of a USD stage, or of a trace that `wmspec run -o` wrote, observe.

    Of several engines, those that refuse it or fail cost only their own pictures; the exit code is 1 then.
    """
    from wmspec.api.drawing import renderer_of

    drawing: Drawing = {"size": parse_size(size), "renderer": renderer, "look": look, "samples": samples}
    seconds = seconds_of(duration) if duration else None
    executions = _executions(source, backend, task, instance, seed, redrawn, seconds)
    many = len(executions) > 1 or backend == "all"
    drawn, causes = 0, list[str]()
    for execute in executions:
        with _counted(causes) if len(executions) > 1 else nullcontext():
            episode = execute()
            renderer_of(episode.engine, **drawing)  # tells what is wrong with it before a folder is made
            name = f"{episode.scene.name.rpartition('/')[2]}-{instance:06d}-{episode.engine}"
            for path in _written(_Pictures(episode, camera, overlay, drawing), output, name, rate, many):
                click.echo(path)
                drawn += 1
    cause = "\n".join(causes[:1])
    settle(Tally("picture was drawn", drawn, "engines", len(executions), len(causes), cause, how="failed", most=0))


@contextmanager
def _counted(causes: list[str]) -> Iterator[None]:
    """Keep why one of several engines cannot execute or draw it. A mistake in what was asked for is raised."""
    try:
        yield
    except (StageError, EngineError, GraphicsError) as error:
        causes.append(str(error))
    except (WmsError, OSError):
        raise
    except Exception as error:  # noqa: BLE001  whatever an engine raises, the others draw
        causes.append(Crash.of(error).told())


@dataclass(frozen=True)
class _Pictures:
    """What is drawn of an episode, and how."""

    episode: Episode
    camera: str
    overlay: bool
    drawing: Drawing


def _executions(
    source: Path, backend: str, task: str, instance: int, seed: int, redrawn: int, seconds: float | None
) -> list[Callable[[], Episode]]:
    """What gives the episodes: one of each engine that executes it, or the one that was written to disk."""
    from wmspec.api import load_episode, open_stage
    from wmspec.api.episode import execute
    from wmspec.runtime.engines.registry import chosen

    suffix = source.suffix.lower()
    if suffix == ".npz":
        return [partial(load_episode, source)]
    given = suffix in STAGES
    stage = open_stage(source) if given else instance_of(source, task, instance, seed, redrawn).stage()

    def executed(engine: str) -> Episode:
        episode = execute(stage, engine, seconds, strict=not given)
        tell_notes([episode])
        return episode

    return [partial(executed, engine) for engine in chosen(backend)]


def _written(pictures: _Pictures, output: Path, name: str, rate: float, many: bool) -> Iterator[Path]:
    """Write what the suffix of the output asks for; with many engines, each to a file of its own."""
    episode, camera = pictures.episode, pictures.camera
    suffix = output.suffix.lower()
    if suffix not in (*FILMS, ".png"):
        if suffix and not output.is_dir():
            raise WmsError("expected a folder, or a file that ends in .png, .gif or .mp4", FilePlace(str(output)))
        yield from _stills(pictures, make_folder(output), name)
        return
    path = output.with_stem(f"{output.stem}-{episode.engine}") if many else output
    make_folder(path.parent)
    if suffix == ".png":
        _saved(episode.sheet(camera, overlay=pictures.overlay, **pictures.drawing), path)
    else:
        episode.film(path, camera, rate=rate, overlay=pictures.overlay, **pictures.drawing)
    yield path


def _stills(pictures: _Pictures, folder: Path, name: str) -> Iterator[Path]:
    episode = pictures.episode
    for camera, time in episode.views(pictures.camera):
        picture = episode.picture(camera, time, overlay=pictures.overlay, **pictures.drawing)
        yield _saved(picture, folder / f"{name}-{camera}-{time:.3f}s.png")


def _saved(picture: Image, path: Path) -> Path:
    try:
        picture.save(path)
    except OSError as error:
        raise WmsError(f"cannot be written: {error.strerror or error}", FilePlace(str(path))) from None
    return path
