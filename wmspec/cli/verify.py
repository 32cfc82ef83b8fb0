"""`wmspec verify`: regenerate part of a dataset and compare."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmspec.cli.common import json_option, tell

if TYPE_CHECKING:
    from wmspec.dataset.verify import Verification

#: The most differences that are printed.
MAX_PRINTED = 10


@click.command("verify")
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option(
    "--sample",
    type=click.IntRange(1),
    default=4,
    show_default=True,
    help="Number of instances per task to regenerate, spread evenly.",
)
@click.option("--all", "every", is_flag=True, help="Regenerate all instances.")
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@click.option(
    "--timeout", type=click.FloatRange(1), default=300.0, show_default=True, help="Time limit per instance, in seconds."
)
@json_option
@click.pass_context
def verify_command(
    ctx: click.Context, dataset: Path, sample: int, every: bool, workers: int | None, timeout: float, as_json: bool
) -> None:
    """Regenerate instances of a DATASET from the specs in its manifest and compare them with its rows.

    If bytes differ, texts, options and answers must be equal, and numbers and pictures close; this is reported. Exits
    with 1 if anything else differs.
    """
    from wmspec.api import progress_bar
    from wmspec.api.verifying import verify

    number = None if every else sample
    result = verify(dataset, sample=number, workers=workers, timeout=timeout, progress=progress_bar, tell=tell)
    if as_json:
        click.echo(json.dumps({"verdict": result.verdict, **asdict(result)}, indent=1, ensure_ascii=False))
    else:
        _print(result)
    ctx.exit(1 if result.verdict == "different" else 0)


def _print(result: Verification) -> None:
    worst = sorted(result.differences, key=lambda difference: difference.near)
    for difference in worst[:MAX_PRINTED]:
        click.echo(f"{'near     ' if difference.near else 'DIFFERENT'} {difference}")
    if len(worst) > MAX_PRINTED:
        click.echo(f"and {len(worst) - MAX_PRINTED:,} more")
    for name, (there, here) in result.versions.items():
        click.echo(f"generated with {name} {there}; installed is {here}")
    words = {
        "same": "byte-identical",
        "near": f"{len(worst):,} not byte-identical; texts, options and answers are equal, numbers and pictures close",
        "different": f"{sum(not d.near for d in worst):,} different",
    }
    click.echo(f"{result.questions:,} questions regenerated: {words[result.verdict]}")
