"""`wmspec conformance`: run the cases of usdphysics-conformance in the installed engines."""

from __future__ import annotations

import json
from pathlib import Path

import click

from wmspec.cli.common import json_option, make_folder
from wmspec.core.diagnostics import WmsError


@click.command("conformance")
@click.argument("cases", nargs=-1, metavar="[CASE]...")
@click.option("--backend", "-b", default="all", show_default=True, help="Engines: comma-separated names, or all.")
@click.option(
    "--output",
    "-o",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="Folder for the traces, as ENGINE/CASE.npz.",
)
@json_option
@click.pass_context
def conformance_command(
    ctx: click.Context, cases: tuple[str, ...], backend: str, output: Path | None, as_json: bool
) -> None:
    """Execute stages with analytic answers in the engines and print how far each engine is off.

    The cases are those of the distribution usdphysics-conformance, whose own command writes stages for other engines
    and scores their traces. Exit code 1 if a result is out of tolerance or an engine refuses a case.
    """
    try:
        from usdphysics_conformance import ConformanceError, Score, score_text, select_cases
    except ImportError:
        remedy = "install it with `pip install 'wmspec[conformance]'`, in a checkout with `pip install ./conformance`"
        raise WmsError("the cases are in the distribution usdphysics-conformance", help=remedy) from None
    from wmspec.runtime.conformance import score_engine
    from wmspec.runtime.engines import registry

    try:
        selected = select_cases(cases)
    except ConformanceError as error:
        raise WmsError(str(error)) from None
    scores: list[Score] = []
    for engine in registry.select_backends(backend):
        folder = make_folder(output / engine) if output else None
        scores += score_engine(engine, selected, folder)
    records = [score.record() for score in scores]
    click.echo(json.dumps(records, indent=2) if as_json else score_text(records))
    ctx.exit(0 if all(score.passed for score in scores) else 1)
