"""`wmspec run`: execute an instance, or a stage from anywhere, and see what happened."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from wmspec.cli.common import instance_of, instance_option, json_option, one_task, seed_option
from wmspec.diagnostics import WmsError

STAGES = (".usd", ".usda", ".usdc", ".usdz")


@click.command("run")
@click.argument("source", type=click.Path(path_type=Path), metavar="SPEC|STAGE")
@click.option(
    "--backend", "-b", default="", help="Engines: names joined by commas, or all.  [default: the first there is]"
)
@instance_option
@seed_option
@click.option(
    "--for",
    "duration",
    default="",
    metavar="TIME",
    help="How long, such as 2s, to the nearest sample; for stages without an episode.",
)
@click.option(
    "--output",
    "-o",
    type=click.Path(path_type=Path),
    help="Write the trace to this .npz file; `wmspec render` draws it.",
)
@json_option
def run_command(
    source: Path, backend: str, instance: int, seed: int, duration: str, output: Path | None, as_json: bool
) -> None:
    """Execute an instance of a spec, or a USD stage, and print where everything ended and what touched."""
    from wmspec.execute.archive import save
    from wmspec.execute.backends import backend as load_backend
    from wmspec.execute.backends import chosen
    from wmspec.usd import read

    stage = load_stage(source, instance, seed)
    scene = read(stage)
    if duration:
        scene = replace(scene, duration=_seconds(duration, scene.rate))
    if scene.duration <= 0 and source.suffix != ".wms":  # a spec may well ask for a single moment
        raise WmsError(f"{source}: the stage does not say how long it lasts; add for instance `--for 2s`")
    engines = chosen(backend)
    if output is not None and len(engines) > 1:
        raise WmsError("one file holds the trace of one engine; choose one with --backend, or leave out --output")
    traces = {name: load_backend(name).execute(scene) for name in engines}
    if output is not None:
        save(stage, traces[engines[0]], output)
    if as_json:
        click.echo(json.dumps([_summary(t, scene) for t in traces.values()], indent=2))
        return
    for trace in traces.values():
        _print(trace, scene)


def load_stage(source: Path, instance: int, seed: int) -> Any:
    """The USD stage of a file, or of an instance of a spec."""
    if source.suffix.lower() in STAGES:
        return _open(source)
    from wmspec.design.design import Design
    from wmspec.stage.episode import document
    from wmspec.stage.layers import compose

    task = one_task(source)
    return compose(document(task, instance_of(Design(task, seed), instance)))


def _open(path: Path) -> Any:
    from pxr import Tf, Usd, UsdUtils

    import wmspec.usd.schema  # noqa: F401  importing it registers the schemas
    from wmspec.importers.usd_open import complaint

    if not path.is_file():
        raise WmsError(f"{path}: there is no such file")
    quiet = UsdUtils.CoalescingDiagnosticDelegate()  # what USD would print is told by us, here and by the reader
    try:
        return Usd.Stage.Open(str(path))
    except Tf.ErrorException as error:
        what = complaint(error, path, str(path))
        raise WmsError(f"{path}: not a stage that USD can open: {what}") from None
    finally:
        del quiet


def _seconds(text: str, rate: int) -> float:
    """The time (s) that is meant, rounded to samples of 1 / `rate` s, as episodes are."""
    from wmspec.check.units import TIME, UnknownUnit, parse_unit

    number = text.rstrip("abcdefghijklmnopqrstuvwxyz ")
    try:
        scale, dimension = parse_unit(text[len(number) :].strip() or "s")
        seconds = float(number) * scale
    except (ValueError, UnknownUnit):
        dimension, seconds = TIME, 0.0
    if dimension != TIME or not 0 < seconds <= 3600:
        raise WmsError(f"--for {text}: expected a time such as 2s or 500ms, up to an hour")
    if seconds * rate < 0.99:  # the time told is rounded
        raise WmsError(f"--for {text}: shorter than one sample; ask for at least {1000 / rate:.3g}ms")
    return round(seconds * rate) / rate


def _summary(trace: Any, scene: Any) -> dict[str, Any]:
    """Of what can move: where it ends, and its touches, in which it comes first."""
    bodies = {}
    for i, body in enumerate(scene.bodies):
        if body.motion != "static":
            bodies[body.name] = {
                "position": trace.position[-1, i].tolist(),
                "orientation": trace.orientation[-1, i].tolist(),
                "velocity": trace.linear_velocity[-1, i].tolist(),
            }
    contacts = []
    for c in trace.contacts:
        first, second = (c.first, c.second) if c.first in bodies else (c.second, c.first)
        if first in bodies:
            contacts.append({"first": first, "second": second, "start": c.start, "stop": c.stop})
    return {"engine": trace.engine, "duration": float(trace.time[-1]), "bodies": bodies, "contacts": contacts}


def _print(trace: Any, scene: Any) -> None:
    summary = _summary(trace, scene)
    click.echo(click.style(f"{trace.engine}, {summary['duration']:g} s", bold=True))
    for name, end in summary["bodies"].items():
        x, y, z = (100 * v for v in end["position"])
        vx, vy, vz = (100 * v for v in end["velocity"])
        click.echo(
            f"  {name:<16} ends at ({x:7.1f}, {y:7.1f}, {z:6.1f}) cm, moving at ({vx:6.1f}, {vy:6.1f}, {vz:6.1f}) cm/s"
        )
    for contact in summary["contacts"]:
        when = f"from {contact['start']:.3f} s to {contact['stop']:.3f} s"
        click.echo(f"  {contact['first']} touches {contact['second']} {when}")
