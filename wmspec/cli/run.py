"""`wmspec run`: execute an instance or a stage and print what happened."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmspec.cli.common import instance_options, json_option, load_instance, paint, tell
from wmspec.core.diagnostics import EngineError, StageError, WmsError
from wmspec.core.limits import EPISODE_SECONDS
from wmspec.core.places import FilePlace
from wmspec.lang.check.tables.vocabulary import STAGES

if TYPE_CHECKING:
    from wmspec.api import Episode


MIN_PARTS, MIN_DEPTH = 3, 2
"""A prim at this depth (`/World/Objects/arm`) with at least this many parts is printed as one line."""

duration_option = click.option(
    "--for",
    "duration",
    default="",
    metavar="TIME",
    help="Duration of a stage without an episode, such as 2s.",
)


@click.command("run")
@click.argument("source", type=click.Path(path_type=Path), metavar="SPEC|STAGE|FILE")
@click.option("--backend", "-b", default="", help="Engines: comma-separated names, or all.  [default: first installed]")
@instance_options
@duration_option
@click.option(
    "--output",
    "-o",
    type=click.Path(path_type=Path),
    help="Write the trace to this .npz file; `wmspec render` draws it.",
)
@click.option(
    "--strict", is_flag=True, help="Refuse stages and asset files with features that would be approximated or ignored."
)
@json_option
def run_command(
    source: Path,
    backend: str,
    task: str,
    instance: int,
    redraw: int,
    seed: int,
    duration: str,
    output: Path | None,
    strict: bool,
    as_json: bool,
) -> None:
    """Execute an instance of a spec, a USD stage, or a URDF, MJCF or mesh file, and print final positions and contacts.

    A URDF or mesh file falls onto an added ground, for 2 s or --for TIME. MJCF gets no ground.

    Exits with 1 if some of several engines refuse it; results of the others are printed.
    """
    from wmspec.api import run
    from wmspec.api.asset_task import RUN_FILES, asset_task
    from wmspec.runtime.engines.registry import select_backends

    engines = select_backends(backend)
    if output is not None and len(engines) > 1:
        raise WmsError("one file holds the trace of one engine; choose one with --backend, or leave out --output")
    seconds = parse_duration(duration) if duration else None
    if source.suffix.lower() == ".npz":
        # Read as a spec, a link in a folder of others would show a line of the file that it leads to.
        raise WmsError("a trace is not executed", FilePlace(str(source)), help="`wmspec render` draws it")
    if source.suffix.lower() in STAGES:
        episodes, refusals = _run_each(engines, lambda engine: run(source, engine, seconds, strict=strict))
    elif source.suffix.lower() in RUN_FILES:
        alone = asset_task(source, seconds, strict=strict, tell=tell)[0]
        episodes, refusals = _run_each(engines, lambda engine: alone.run(engine, strict=strict))
    else:
        one = load_instance(source, task, instance, seed, redraw, strict=strict)
        episodes, refusals = _run_each(engines, lambda engine: one.run(engine, duration=seconds, strict=strict))
    if output is not None and episodes:
        episodes[0].save(output)
    if as_json:
        refused = [{"engine": e, "refused": [d.record() for d in error.diagnostics]} for e, error in refusals.items()]
        click.echo(json.dumps([*map(_summary, episodes), *refused], indent=2))
    else:
        print_notes(episodes)
        for episode in episodes:
            _print(episode)
    if refusals:
        error = WmsError.of(dict.fromkeys(d for error in refusals.values() for d in error.diagnostics))
        if not episodes:
            raise error
        tell(error.render(paint()))
        raise SystemExit(1)


def _run_each(engines: Sequence[str], execute: Callable[[str], Episode]) -> tuple[list[Episode], dict[str, WmsError]]:
    """Return the episodes of the engines that can execute it, and the refusals by engine."""
    episodes: list[Episode] = []
    refusals: dict[str, WmsError] = {}
    for engine in engines:
        try:
            episodes.append(execute(engine))
        except (StageError, EngineError) as error:
            refusals[engine] = error
    return episodes, refusals


def print_notes(episodes: Sequence[Episode]) -> None:
    """Print the notes of all episodes, each once."""
    for note in dict.fromkeys(note for episode in episodes for note in episode.notes):
        tell(note.render(paint()))


def parse_duration(text: str) -> float:
    """Parse a time in seconds."""
    from wmspec.lang.check.types.units import TIME, parse_quantity

    seconds = parse_quantity(text, "s", TIME)
    if seconds is None or not 0 < seconds <= EPISODE_SECONDS.most:
        raise WmsError(f"--for {text}: expected a time such as 2s or 500ms, up to {EPISODE_SECONDS.most} s")
    return seconds


def _summary(episode: Episode) -> dict[str, Any]:
    """Return the final state of movable bodies, and their contacts; a movable body is named first."""
    bodies = {}
    for name in episode.movable:
        track = episode[name]
        bodies[name] = {
            "position": track.position[-1].tolist(),
            "middle": track.center[-1].tolist(),
            "orientation": track.orientation[-1].tolist(),
            "velocity": track.linear_velocity[-1].tolist(),
        }
    contacts = []
    for c in episode.contacts:
        first, second = (c.first, c.second) if c.first in bodies else (c.second, c.first)
        if first in bodies:
            contacts.append({"first": first, "second": second, "start": c.start, "stop": c.stop})
    return {
        "engine": episode.engine,
        "duration": float(episode.time[-1]),
        "bodies": bodies,
        "contacts": contacts,
        **({"notes": [note.record() for note in episode.notes]} if episode.notes else {}),
    }


def _print(episode: Episode) -> None:
    summary = _summary(episode)
    click.echo(click.style(f"{episode.engine}, {summary['duration']:g} s", bold=True))
    links = _links(episode)
    for path, count in Counter(links.values()).items():
        click.echo(f"  {path.rpartition('/')[2]:<16} has {count} parts that move as planned")
    for name, end in summary["bodies"].items():
        if name in links:
            continue
        x, y, z = (100 * v for v in end["middle"])
        vx, vy, vz = (100 * v for v in end["velocity"])
        click.echo(
            f"  {name:<16} ends at ({x:7.1f}, {y:7.1f}, {z:6.1f}) cm, moving at ({vx:6.1f}, {vy:6.1f}, {vz:6.1f}) cm/s"
        )
    for contact in summary["contacts"]:
        when = f"from {contact['start']:.3f} s to {contact['stop']:.3f} s"
        click.echo(f"  {contact['first']} touches {contact['second']} {when}")


def _links(episode: Episode) -> dict[str, str]:
    """Return kinematic bodies that are parts of an articulated whole, such as links of an arm: name -> path of the
    whole.
    """
    led = {b.name: b.path.rpartition("/")[0] for b in episode.scene.bodies if b.motion == "kinematic"}
    wholes = Counter(led.values())
    return {name: whole for name, whole in led.items() if wholes[whole] >= MIN_PARTS and whole.count("/") > MIN_DEPTH}
