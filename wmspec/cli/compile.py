"""`wmspec compile`: stages, and what an engine loads by itself."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.cli.common import (
    instance_of,
    instance_option,
    make_folder,
    one_task,
    seed_option,
    spec_argument,
    write_text,
)
from wmspec.diagnostics import WmsError


@click.command("compile")
@spec_argument
@click.option("--backend", "-b", default="", help="Engines to write native files for: names joined by commas, or all.")
@instance_option
@seed_option
@click.option("--output", "-o", type=click.Path(path_type=Path), help="The folder to write to.")
@click.option("--ir", is_flag=True, help="Write no files; print the checked task as JSON (see `wmspec schema`).")
def compile_command(spec: Path, backend: str, instance: int, seed: int, output: Path | None, ir: bool) -> None:
    """Write an instance as USD and in an engine's own form.

    The stage is a base layer for the task with a layer over it for the instance, and one for each counterfactual over
    that. The native files (a model, or a script) run in their engine without wmspec.
    """
    from wmspec.design.design import Design
    from wmspec.execute.backends import backend as load_backend
    from wmspec.execute.backends import chosen
    from wmspec.stage.episode import document
    from wmspec.stage.layers import compose
    from wmspec.stage.write import write_stages
    from wmspec.usd import read

    task = one_task(spec)
    if ir:
        from wmspec.check.record import to_json

        click.echo(to_json(task, indent=2))
        return
    if output is None:
        raise WmsError("say where to write: `--output FOLDER`, or `--ir` to print the checked task")
    design = Design(task, seed)
    chosen_instance = instance_of(design, instance)
    folder = make_folder(output / task.name)
    written = write_stages(design, chosen_instance, folder)
    if backend:
        scene = read(compose(document(task, chosen_instance)))
        for name in chosen(backend):
            native = make_folder(folder / f"{instance:06d}.{name}")
            for file, text in load_backend(name).native(scene).items():
                written.append(write_text(native / file, text))
    for path in written:
        click.echo(path)
