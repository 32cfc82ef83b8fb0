"""`wmspec seal`: a dataset that stays private, and can be shown later to be the one."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.cli.common import tell
from wmspec.core.diagnostics import WmsError


@click.command("seal")
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option("--output", "-o", type=click.Path(path_type=Path), help="The folder to publish.")
@click.option("--check", "sealed_as", type=click.Path(path_type=Path), help="Is the DATASET the one of this seal.json?")
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@click.pass_context
def seal_command(
    ctx: click.Context, dataset: Path, output: Path | None, sealed_as: Path | None, workers: int | None
) -> None:
    """Seal a DATASET that stays private.

    What is written to publish is seal.json, the hashes of its seed, specs and rows, and debug/, a dataset of a tenth of
    its tasks made with seed 0. With --check, compare a dataset with a seal; exit code 1 if it is another.
    """
    from wmspec.api import progress_bar
    from wmspec.api.sealing import check, seal

    if (output is None) == (sealed_as is None):
        raise WmsError("give either -o FOLDER, to seal the dataset, or --check SEAL.json, to compare it with its seal")
    if output is not None:
        seal(dataset, output, workers=workers, progress=progress_bar, tell=tell)
        click.echo(f"{output / 'seal.json'} and {output / 'debug'} can be published; keep {dataset} and its seed")
        return
    assert sealed_as is not None
    differing = check(dataset, sealed_as)
    for sentence in differing:
        click.echo(sentence)
    click.echo("this is another dataset" if differing else "this is the dataset that was sealed")
    ctx.exit(1 if differing else 0)
