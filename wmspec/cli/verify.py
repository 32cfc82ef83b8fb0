"""`wmspec verify`: recompute a dataset, or a sample of it, and compare."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmspec.cli.common import instance_timeout_option, json_option, tell

if TYPE_CHECKING:
    from wmspec.dataset.verify.model import Verification

#: The most differences that are printed.
MAX_PRINTED = 10


@click.command("verify")
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option(
    "--sample",
    type=click.IntRange(1),
    help="Number of rows, and of rejected questions, to generate again.  "
    "[default: as many as detect with 99 % probability that 5 % of the rows changed]",
)
@click.option("--all", "every", is_flag=True, help="Generate all questions again.")
@click.option("--sample-seed", type=int, help="Draw the sample of an earlier run again.  [default: a new sample]")
@click.option(
    "--other-machine",
    is_flag=True,
    help="Accept small differences of numbers and pictures: the dataset was made with other graphics or processors.",
)
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@instance_timeout_option
@json_option
@click.pass_context
def verify_command(ctx: click.Context, /, dataset: Path, as_json: bool, **options: Any) -> None:
    """Recompute a DATASET from the specs and seed in its manifest and compare.

    Checks every file of the folder, and ids, order, counts and factors of every row, and generates a random sample of
    questions again. If versions differ, numbers and pictures may differ a little; this is reported. Exits with 1 if
    anything else differs.
    """
    from wmspec.api import progress_bar
    from wmspec.api.verifying import verify

    result = verify(dataset, progress=progress_bar, tell=tell, **options)
    if as_json:
        click.echo(json.dumps({"verdict": result.verdict, **asdict(result)}, indent=1, ensure_ascii=False))
    else:
        _print(result, options["every"])
    ctx.exit(1 if result.verdict == "different" else 0)


def _print(result: Verification, every: bool) -> None:
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
    click.echo(f"{result.questions:,} of {result.planned:,} questions generated again: {words[result.verdict]}")
    if not every:
        click.echo(
            f"A change in {result.power.share:.0%} of the rows, or of the rejected questions, is found with a "
            f"probability of {result.power.found:.1%} (--sample-seed {result.sample_seed})."
        )
    for sentence in result.limits:
        click.echo(f"Not covered: {sentence}.")
