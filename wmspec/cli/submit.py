"""`wmspec submit`: check a submission to published questions."""

from __future__ import annotations

from pathlib import Path

import click

_PATH = click.Path(path_type=Path)


@click.command("submit")
@click.argument("questions", type=_PATH)
@click.argument("submission", type=_PATH)
@click.pass_context
def submit_command(ctx: click.Context, questions: Path, submission: Path) -> None:
    """Check a submission before it is sent to those who hold the answers.

    QUESTIONS is a folder of `wmspec export --to questions`, SUBMISSION a file of JSON lines. Exits with 1 if a question
    has no reply.
    """
    from wmspec.eval.publish import questions as published
    from wmspec.eval.publish import submission as submissions

    known = published.read(questions)
    found = submissions.read(submission, known)
    outcomes = found.outcomes(known)
    click.echo(
        f"{found.about.model}, prompt {found.about.prompt}: {len(found.replies):,} of {len(known.questions):,} replies"
    )
    click.echo(", ".join(f"{count:,} {outcome}" for outcome, count in outcomes.items()))
    missing = len(known.questions) - len(found.replies)
    if missing:
        click.echo(f"{missing:,} questions have no reply and would count as wrong")
    click.echo(f"digest of the submission: {found.digest}")
    ctx.exit(1 if missing else 0)
