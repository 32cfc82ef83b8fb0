"""`wmspec report`: analyse results of models and people."""

from __future__ import annotations

import os
from importlib.util import find_spec
from pathlib import Path

import click

from wmspec.api.progress import progress_bar
from wmspec.cli.common import json_option, make_folder
from wmspec.core.diagnostics import WmsError


@click.command("report")
@click.argument("results", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--dataset",
    type=click.Path(path_type=Path),
    help="The evaluated dataset, for analyses of factors, differences, pairs and counterfactuals.",
)
@click.option(
    "--output",
    "-o",
    type=click.Path(path_type=Path),
    default=Path("report"),
    show_default=True,
    help="Folder for report.html, report.json, figures and tables.",
)
@json_option
def report_command(results: tuple[Path, ...], dataset: Path | None, output: Path, as_json: bool) -> None:
    """Report results: tables, intervals, comparisons, psychometric curves, entanglement, difficulty.

    RESULTS are files of `wmspec evaluate` and `wmspec study collect`, or folders of them.
    """
    # Before the import of NumPy: one thread gives the same sums on any number of cores.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    lacking = [name for name in ("pandas", "matplotlib", "statsmodels") if find_spec(name) is None]
    if lacking:
        raise WmsError(f"a report needs {', '.join(lacking)}; install it with: pip install 'wmspec[report]'")
    from wmspec.eval.report.page import lost_answers, summary, warnings
    from wmspec.eval.report.report import STEPS, report
    from wmspec.eval.report.write import text, write

    with progress_bar(STEPS, "analysing", "analyses") as progress:
        made = report(list(results), dataset, progress)
    page = write(made, make_folder(output))
    if as_json:
        click.echo(text(made), nl=False)
        return
    for sentence in (*summary(made), *warnings(made), *lost_answers(made)):
        click.echo(sentence)
    click.echo(page)
