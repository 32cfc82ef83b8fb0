"""`wmspec compile`: stages, and what an engine loads by itself."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.cli.common import (
    instance_of,
    instance_option,
    make_folder,
    redrawn_option,
    seed_option,
    spec_argument,
    task_option,
    write_text,
)
from wmspec.core.diagnostics import WmsError


@click.command("compile")
@spec_argument
@click.option("--backend", "-b", default="", help="Engines to write native files for: names joined by commas, or all.")
@task_option
@instance_option
@redrawn_option
@seed_option
@click.option("--output", "-o", type=click.Path(path_type=Path), help="The folder to write to.")
@click.option("--ir", is_flag=True, help="Write no files; print the checked task as JSON (see `wmspec schema`).")
def compile_command(
    spec: Path, backend: str, task: str, instance: int, redrawn: int, seed: int, output: Path | None, ir: bool
) -> None:
    """Write an instance as USD and in an engine's own form.

    The stage is a base layer for the task with a layer over it for the instance, and one for each counterfactual over
    that. The native files (a model, or a script) run in their engine without wmspec.
    """
    from wmspec.runtime.engines.registry import chosen

    chosen_instance = instance_of(spec, task, instance, seed, redrawn)
    checked = chosen_instance.task
    if ir:
        click.echo(checked.to_json())
        return
    if output is None:
        raise WmsError("say where to write: `--output FOLDER`, or `--ir` to print the checked task")
    folder = make_folder(output / checked.name)
    written = chosen_instance.write(folder)
    for engine in chosen(backend) if backend else ():
        native = make_folder(folder / f"{instance:06d}.{engine}")
        written += [write_text(native / file, text) for file, text in chosen_instance.native(engine).items()]
    for path in written:
        click.echo(path)
