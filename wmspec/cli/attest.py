"""`wmspec attest`: publish hashes of a dataset that stays private."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.cli.common import tell
from wmspec.core.diagnostics import WmsError


@click.command("attest")
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option("--output", "-o", type=click.Path(path_type=Path), help="Folder to publish.")
@click.option("--check", "sealed_as", type=click.Path(path_type=Path), help="Check DATASET against this seal.json.")
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@click.pass_context
def attest_command(
    ctx: click.Context, dataset: Path, output: Path | None, sealed_as: Path | None, workers: int | None
) -> None:
    """Attest a DATASET that stays private.

    Writes for publication: seal.json (hashes of seed, specs and rows) and debug/ (a dataset of a tenth of the tasks
    with seed 0). With --check, compares a dataset with a seal; exits with 1 if they differ.
    """
    from wmspec.api import progress_bar
    from wmspec.api.attesting import attest, check

    if (output is None) == (sealed_as is None):
        raise WmsError("give either -o FOLDER, to seal the dataset, or --check SEAL.json, to compare it with its seal")
    if output is not None:
        attest(dataset, output, workers=workers, progress=progress_bar, tell=tell)
        click.echo(f"{output / 'seal.json'} and {output / 'debug'} can be published; keep {dataset} and its seed")
        return
    assert sealed_as is not None
    differing = check(dataset, sealed_as)
    for sentence in differing:
        click.echo(sentence)
    click.echo("this is another dataset" if differing else "this is the dataset that was sealed")
    ctx.exit(1 if differing else 0)
