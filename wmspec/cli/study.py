"""`wmspec study`: run a study with people."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import click

from wmspec.cli.common import json_option, make_folder, seed_option, write_text
from wmspec.core.diagnostics import WmsError

_PATH = click.Path(path_type=Path)
#: People in a batch.
BATCH = 10


@click.group("study")
def study_command() -> None:
    """Run a study with people: make it, serve it, collect the answers.

    See docs/study.md.
    """


@study_command.command("make")
@click.argument("dataset", type=_PATH)
@click.option("--output", "-o", type=_PATH, default=Path("study"), show_default=True, help="Study folder.")
@click.option("--per-task", type=click.IntRange(1), default=50, show_default=True, help="Questions per task.")
@click.option("--raters", type=click.IntRange(1, 1000), default=3, show_default=True, help="Participants per question.")
@click.option(
    "--per-person",
    type=click.IntRange(1),
    default=100,
    show_default=True,
    help="Maximum number of questions per participant.",
)
@click.option(
    "--practice",
    type=click.IntRange(0),
    default=1,
    show_default=True,
    help="Practice questions with feedback per task.",
)
@click.option(
    "--check-every",
    type=click.IntRange(0),
    default=20,
    show_default=True,
    help="Interval between attention checks; 0 for none.",
)
@click.option("--task", multiple=True, metavar="NAME", help="Only this task.")
@click.option("--engine", multiple=True, metavar="NAME", help="Only rows of this engine.")
@seed_option
def make_command(dataset: Path, output: Path, **flags: object) -> None:
    """Create a study: assignment and order of questions, the page, and texts to edit."""
    from wmspec.dataset.build.reader import DatasetReader
    from wmspec.eval.study.make import StudyOptions, make
    from wmspec.eval.study.page import unfinished_texts

    fields = {{"task": "tasks", "engine": "engines"}.get(name, name): value for name, value in flags.items()}
    options = StudyOptions(**fields)  # type: ignore[arg-type]
    study = make(DatasetReader.open(dataset), options, make_folder(output))
    count = sum(item.kind == "question" for item in study.items)
    click.echo(
        f"{output}: {count:,} questions, {study.raters} raters each: {len(study.slots)} people, "
        f"{max(map(len, study.slots))} pages at most"
    )
    for path in unfinished_texts(output):
        click.echo(f"{path}: fill in the text in brackets, then repeat this command", err=True)


@study_command.command("serve")
@click.argument("study", type=_PATH, default=Path("study"))
@click.option(
    "--host", default="127.0.0.1", show_default=True, help="Address to bind; 0.0.0.0 is reachable by everybody."
)
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8000, show_default=True, help="Port; 0 selects a free one."
)
@click.option(
    "--batches",
    type=click.IntRange(1),
    metavar="N",
    help="Invite the first N batches of ten people.  [default: all]",
)
def serve_command(study: Path, host: str, port: int, batches: int | None) -> None:
    """Serve a study and store the answers until stopped.

    Safe to stop at any time: an answer is on disk before the page is notified.
    """
    from wmspec.eval.study.page import unfinished_texts
    from wmspec.eval.study.serve import StudyServer

    with StudyServer(study, host, port, batches and batches * BATCH) as server:
        for path in unfinished_texts(study):
            click.echo(f"{path}: contains unedited text in brackets", err=True)
        if not server.is_local:
            click.echo("reachable by others without encryption; put an HTTPS proxy in front of it", err=True)
        click.echo(f"{server.url}  (stop with Ctrl+C)")
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            click.echo("stopped")


@study_command.command("collect")
@click.argument("study", type=_PATH)
@click.argument("answers", nargs=-1, type=_PATH)
@click.option("--output", "-o", type=_PATH, required=True, metavar="FILE", help="Results file (.parquet).")
@click.option(
    "--least-checks", type=click.FloatRange(0, 1), default=0.0, show_default=True, metavar="SHARE",
    help="Exclude participants who passed a smaller share of attention checks.",
)  # fmt: skip
@click.option("--payments", type=_PATH, metavar="FILE", help="Also write a payment sheet (.csv).")
@json_option
def collect_command(
    study: Path, answers: tuple[Path, ...], output: Path, least_checks: float, payments: Path | None, as_json: bool
) -> None:
    """Write answers as results for `wmspec report`, and print accuracy and agreement.

    ANSWERS are files saved by the page without a server.
    """
    from wmspec.eval.study.collect import collect
    from wmspec.eval.study.collect import payments as sheet

    if output.suffix != ".parquet":
        raise WmsError("missing output: add -o results.parquet")
    made = collect(study, answers, output, least_checks)
    if payments is not None:
        write_text(payments, sheet(made.raters))
    if as_json:
        click.echo(json.dumps(asdict(made), indent=1))
        return
    for rater in made.raters:
        pace = f"{rater.seconds:.1f} s a question" if rater.seconds is not None else "no question"
        click.echo(
            f"{rater.rater}: {rater.answered} of {rater.steps} pages, checks {rater.checks_passed}/{rater.checks}, "
            f"right {rater.right}/{rater.questions}, {pace}" + ("" if rater.counted else "; left out")
        )
    for agreed in made.agreement:
        alpha = "none" if agreed.alpha is None else f"{agreed.alpha:.3f}"
        click.echo(
            f"{agreed.task or 'all'}: {agreed.questions:,} questions, {agreed.choices:,} choices, "
            f"Krippendorff's α {alpha}, the majority is right in {agreed.majority:.1%}"
        )
    lacking = f"; {made.missing:,} replies are missing" if made.missing else ""
    click.echo(f"{output}: {made.replies:,} replies{lacking}")
