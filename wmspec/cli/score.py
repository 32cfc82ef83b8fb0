"""`wmspec score`: score a submission and sign a receipt."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path

import click

from wmspec.cli.common import make_folder, write_text

_PATH = click.Path(path_type=Path)


@click.command("score")
@click.argument("dataset", type=_PATH)
@click.argument("questions", type=_PATH)
@click.argument("submission", type=_PATH)
@click.option(
    "--secret", type=_PATH, required=True, metavar="FILE", help="Secret that the questions were exported with."
)
@click.option("--output", "-o", type=_PATH, required=True, metavar="FILE", help="Receipt (.json).")
@click.option(
    "--results",
    type=_PATH,
    metavar="FILE",
    help="Also write private results (.parquet), one row a reply, for `wmspec report`.",
)
@click.option(
    "--date", type=click.DateTime(["%Y-%m-%d"]), metavar="DATE", help="Date of the receipt.  [default: today, in UTC]"
)
def score_command(
    dataset: Path,
    questions: Path,
    submission: Path,
    secret: Path,
    output: Path,
    results: Path | None,
    date: datetime | None,
) -> None:
    """Score a submission with the private DATASET, and write a signed receipt.

    QUESTIONS is the folder that was published. The receipt holds the model, its outcomes, scores with intervals, and
    digests of questions and submission. `wmspec leaderboard` refuses receipts that were edited.
    """
    from wmspec.dataset.build.reader import DatasetReader
    from wmspec.eval.models.results import write as write_results
    from wmspec.eval.publish import questions as published
    from wmspec.eval.publish import receipt
    from wmspec.eval.publish import submission as submissions
    from wmspec.eval.publish.secret import Secret

    key, known = Secret.read(secret), published.read(questions)
    opened = DatasetReader.open(dataset).intact()
    day = (date or datetime.now(UTC)).date().isoformat()
    sent = submissions.read(submission, known)
    rows = receipt.scored(opened, known, sent, key)
    made = receipt.receipt(opened, known, sent, key, day, rows)
    if results is not None:
        write_results(results, rows, {"submission": sent.digest, "questions": known.digest})
    make_folder(output.parent)
    write_text(output, json.dumps(made, indent=1, ensure_ascii=False) + "\n")
    for kind, scores in made["scores"].items():
        average, chance = scores["average"], scores["chance"]
        interval = f" [{average['low']:.1%}, {average['high']:.1%}]" if average["low"] is not None else ""
        guess = f"; guessing: {chance:.1%}" if chance is not None else ""
        click.echo(f"{kind}: {average['value']:.1%}{interval}{guess}")
    click.echo(output)
