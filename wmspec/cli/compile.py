"""`wmspec compile`: write stages and native files of engines."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.cli.common import instance_options, load_instance, make_folder, spec_argument, write_text
from wmspec.core.diagnostics import WmsError


@click.command("compile")
@spec_argument
@click.option("--backend", "-b", default="", help="Engines to write native files for: comma-separated names, or all.")
@instance_options
@click.option("--output", "-o", type=click.Path(path_type=Path), help="Output folder.")
@click.option("--ir", is_flag=True, help="Print the checked task as JSON (see `wmspec schema`) and write no files.")
def compile_command(
    spec: Path, backend: str, task: str, instance: int, redraw: int, seed: int, output: Path | None, ir: bool
) -> None:
    """Write an instance as USD and in the native formats of engines.

    The stage has a base layer (the task), an override layer (the instance), and above it one layer for each
    counterfactual. The native files (a model, or a script) run in their engine without wmspec.
    """
    from wmspec.runtime.engines.registry import select_backends

    chosen_instance = load_instance(spec, task, instance, seed, redraw)
    checked = chosen_instance.task
    if ir:
        click.echo(checked.to_json())
        return
    if output is None:
        raise WmsError("missing option --output FOLDER, or --ir to print the checked task")
    folder = make_folder(output / checked.name)
    written = chosen_instance.write(folder)
    for engine in select_backends(backend) if backend else ():
        native = make_folder(folder / f"{instance:06d}.{engine}")
        written += [write_text(native / file, text) for file, text in chosen_instance.native(engine).items()]
    for path in written:
        click.echo(path)
