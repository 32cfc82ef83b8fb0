"""`wmspec verify`: do a dataset's rows come out again?"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmspec.cli.common import json_option, tell

if TYPE_CHECKING:
    from wmspec.dataset.verify import Verification

#: So many differences are told one by one.
TOLD = 10


@click.command("verify")
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option(
    "--sample",
    type=click.IntRange(1),
    default=4,
    show_default=True,
    help="Make so many instances of each task again, spread over it.",
)
@click.option("--all", "every", is_flag=True, help="Make all of them again.")
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@click.option(
    "--timeout", type=click.FloatRange(1), default=300.0, show_default=True, help="Seconds an instance may take."
)
@json_option
@click.pass_context
def verify_command(
    ctx: click.Context, dataset: Path, sample: int, every: bool, workers: int | None, timeout: float, as_json: bool
) -> None:
    """Make instances of a DATASET again, from the specs in its manifest, and compare them with its rows.

    Where they are not the same to the byte, texts, options and answers must still be the same, and numbers and pictures
    nearly so: that is told. Exit code 1 if anything else differs.
    """
    from wmspec.api import progress_bar
    from wmspec.api.verifying import verify

    number = None if every else sample
    result = verify(dataset, sample=number, workers=workers, timeout=timeout, progress=progress_bar, tell=tell)
    if as_json:
        click.echo(json.dumps({"verdict": result.verdict, **asdict(result)}, indent=1, ensure_ascii=False))
    else:
        _tell(result)
    ctx.exit(1 if result.verdict == "different" else 0)


def _tell(result: Verification) -> None:
    worst = sorted(result.differences, key=lambda difference: difference.near)
    for difference in worst[:TOLD]:
        click.echo(f"{'near     ' if difference.near else 'DIFFERENT'} {difference}")
    if len(worst) > TOLD:
        click.echo(f"and {len(worst) - TOLD:,} more")
    for name, (there, here) in result.versions.items():
        click.echo(f"made with {name} {there}; here is {here}")
    words = {
        "same": "all the same to the byte",
        "near": f"{len(worst):,} not to the byte; texts, options and answers are the same, numbers and pictures near",
        "different": f"{sum(not d.near for d in worst):,} different",
    }
    click.echo(f"{result.questions:,} questions made again: {words[result.verdict]}")
