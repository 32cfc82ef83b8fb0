"""`wmspec study`: people answer the questions of a dataset."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import click

from wmspec.cli.common import json_option, make_folder, seed_option
from wmspec.core.diagnostics import WmsError

_PATH = click.Path(path_type=Path)


@click.group("study")
def study_command() -> None:
    """People answer the questions of a dataset: make a study, serve it, collect the answers.

    docs/study.md goes through it.
    """


@study_command.command("make")
@click.argument("dataset", type=_PATH)
@click.option("--output", "-o", type=_PATH, default=Path("study"), show_default=True, help="The study's folder.")
@click.option("--per-task", type=click.IntRange(1), default=50, show_default=True, help="Questions of each task.")
@click.option("--raters", type=click.IntRange(1, 1000), default=3, show_default=True, help="People for each question.")
@click.option(
    "--per-person", type=click.IntRange(1), default=100, show_default=True, help="At most so many questions to one."
)
@click.option("--practice", type=click.IntRange(0), default=1, show_default=True, help="With feedback, in each task.")
@click.option(
    "--check-every", type=click.IntRange(0), default=20, show_default=True, help="A check of attention; 0: none."
)
@click.option("--task", multiple=True, metavar="NAME", help="Only this task.")
@click.option("--engine", multiple=True, metavar="NAME", help="Only what this engine executed.")
@seed_option
def make_command(dataset: Path, output: Path, **flags: object) -> None:
    """Write a study: who is shown which questions in which order, the page, and texts that you may replace."""
    from wmspec.dataset.build.reader import DatasetReader
    from wmspec.eval.study.make import Options, make
    from wmspec.eval.study.page import unfinished

    fields = {{"task": "tasks", "engine": "engines"}.get(name, name): value for name, value in flags.items()}
    options = Options(**fields)  # type: ignore[arg-type]
    study = make(DatasetReader.open(dataset), options, make_folder(output))
    asked = sum(item.kind == "question" for item in study.items)
    click.echo(
        f"{output}: {asked:,} questions, {study.raters} raters each: {len(study.slots)} people, "
        f"{max(map(len, study.slots))} pages at most"
    )
    for path in unfinished(output):
        click.echo(f"{path}: say what is in brackets there, then give this command again", err=True)


@study_command.command("serve")
@click.argument("study", type=_PATH, default=Path("study"))
@click.option("--host", default="127.0.0.1", show_default=True, help="Who can reach it: 0.0.0.0 is everybody.")
@click.option("--port", type=click.IntRange(0, 65535), default=8000, show_default=True, help="0: any that is free.")
def serve_command(study: Path, host: str, port: int) -> None:
    """Show a study to people and keep their answers, until it is stopped.

    Stopped or killed, it goes on where it was: an answer is on the disk before the page is told so.
    """
    from wmspec.eval.study.page import unfinished
    from wmspec.eval.study.serve import Server

    with Server(study, host, port) as server:
        for path in unfinished(study):
            click.echo(f"{path}: people will read what is in brackets there", err=True)
        if not server.is_local:
            click.echo(
                "others can reach it, and nothing is encrypted: put a server that speaks https before it", err=True
            )
        click.echo(f"{server.url}  (Ctrl+C ends it)")
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            click.echo("stopped")


@study_command.command("collect")
@click.argument("study", type=_PATH)
@click.argument("answers", nargs=-1, type=_PATH)
@click.option("--output", "-o", type=_PATH, required=True, metavar="FILE", help="The results, a .parquet file.")
@click.option(
    "--least-checks", type=click.FloatRange(0, 1), default=0.0, show_default=True, metavar="SHARE",
    help="Leave out who passed a smaller share of the checks of attention.",
)  # fmt: skip
@json_option
def collect_command(study: Path, answers: tuple[Path, ...], output: Path, least_checks: float, as_json: bool) -> None:
    """Write what people answered as results, for `wmspec report`, and tell how they did and how far they agree.

    ANSWERS are the files that the page gives where there is no server.
    """
    from wmspec.eval.study.collect import collect

    if output.suffix != ".parquet":
        raise WmsError("where to? the results are a .parquet file: add -o results.parquet")
    made = collect(study, answers, output, least_checks)
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
        kappa = "none" if agreed.kappa is None else f"{agreed.kappa:.3f}"
        click.echo(
            f"{agreed.task or 'all'}: {agreed.questions:,} questions, {agreed.choices:,} choices, Fleiss' κ {kappa}, "
            f"the majority is right in {agreed.majority:.1%}"
        )
    lacking = f"; {made.missing:,} replies are still wanted" if made.missing else ""
    click.echo(f"{output}: {made.replies:,} replies{lacking}")
