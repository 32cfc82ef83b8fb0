"""`wmspec report`: analyse results of models and people."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
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
@click.option(
    "--ranks",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="RESULTS",
    help="Results of the same models on another dataset: print how similar the two rankings are. Repeatable.",
)
@click.option(
    "--equate",
    "earlier",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="RESULTS",
    help="Results on an earlier set of the same design: convert the scores to its scale. Repeatable.",
)
@click.option(
    "--holdout",
    "holdouts",
    multiple=True,
    metavar="LEVELS",
    help="Levels never combined in training, such as shape=cone,color=blue: reported separately. Repeatable.",
)
@click.option("--name", "names", multiple=True, metavar="ID=NAME", help="Display name of a model. Repeatable.")
@json_option
def report_command(
    results: tuple[Path, ...],
    dataset: Path | None,
    output: Path,
    ranks: tuple[Path, ...],
    earlier: tuple[Path, ...],
    holdouts: tuple[str, ...],
    names: tuple[str, ...],
    as_json: bool,
) -> None:
    """Report results: tables, intervals, comparisons, psychometric curves, entanglement, difficulty.

    RESULTS are files of `wmspec evaluate` and `wmspec study collect`, or folders of them.
    """
    # Before the import of NumPy: one thread gives the same sums on any number of cores.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    lacking = [name for name in ("pandas", "matplotlib", "statsmodels") if find_spec(name) is None]
    if lacking:
        raise WmsError(f"a report needs {', '.join(lacking)}; install it with: pip install 'wmspec[report]'")
    if ranks:
        _print_ranks(results, ranks, names, as_json)
        return
    if earlier:
        _print_equated(results, earlier, names, as_json)
        return
    from wmspec.eval.models.splits import Splits
    from wmspec.eval.report.page import lost_answers, summary, warnings
    from wmspec.eval.report.replies import read_strips
    from wmspec.eval.report.report import STEPS, report
    from wmspec.eval.report.write import text, write

    with progress_bar(STEPS, "analysing", "analyses") as progress:
        made = report(list(results), dataset, progress, _display_names(names), Splits.parse("", holdouts))
    page = write(made, make_folder(output), read_strips(list(results)))
    if as_json:
        click.echo(text(made), nl=False)
        return
    for sentence in (*summary(made), *warnings(made), *lost_answers(made)):
        click.echo(sentence)
    click.echo(page)


def _display_names(written: tuple[str, ...]) -> dict[str, str]:
    """Return display names by model. Raises WmsError for one that is not ID=NAME."""
    names = {}
    for each in written:
        id, equals, name = each.rpartition("=")
        if not id or not equals or not name.strip():
            raise WmsError(f"--name {each}: expected ID=NAME, such as openai:gpt-4o=GPT-4o")
        names[id] = name.strip()
    return names


def _print_ranks(results: tuple[Path, ...], others: tuple[Path, ...], names: tuple[str, ...], as_json: bool) -> None:
    from wmspec.eval.report.frames import format_percent
    from wmspec.eval.report.ranks import MIN_MODELS, rank_agreement
    from wmspec.eval.report.replies import read

    first, second = (read(list(paths), None, {}) for paths in (results, others))
    found = rank_agreement(first, second)
    if not found:
        raise WmsError(f"--ranks: fewer than {MIN_MODELS} models have results in both")
    if as_json:
        click.echo(json.dumps([asdict(agreement) for agreement in found], indent=1))
        return
    shown = _display_names(names)
    for agreement in found:
        click.echo(f"{agreement.kind or 'all'}: {len(agreement.models)} models")
        for name, estimate in (("Spearman's ρ", agreement.spearman), ("Kendall's τ", agreement.kendall)):
            interval = f" [{estimate.low:.2f}, {estimate.high:.2f}]" if estimate.sure else ""
            click.echo(f"  {name} {estimate.value:.2f}{interval}")
        rows = sorted(zip(agreement.models, agreement.first, agreement.second, strict=True), key=lambda row: -row[1])
        for model, here, there in rows:
            click.echo(f"  {shown.get(model, model)}: {format_percent(here)} % and {format_percent(there)} %")


def _print_equated(results: tuple[Path, ...], earlier: tuple[Path, ...], names: tuple[str, ...], as_json: bool) -> None:
    from wmspec.eval.report.equating import equate
    from wmspec.eval.report.frames import format_percent
    from wmspec.eval.report.replies import read

    found = equate(*(read(list(paths), None, {}) for paths in (results, earlier)))
    if as_json:
        click.echo(json.dumps([asdict(equated) for equated in found], indent=1))
        return
    shown = _display_names(names)
    for equated in found:
        shift = equated.shift
        interval = f" [{format_percent(shift.low)}, {format_percent(shift.high)}]" if shift.sure else ""
        click.echo(
            f"{equated.kind or 'all'}: the new questions are harder by {format_percent(shift.value)} %{interval}"
        )
        for score in equated.scores:
            value = score.equated
            interval = f" [{format_percent(value.low)}, {format_percent(value.high)}]" if value.sure else ""
            there = f"; earlier {format_percent(score.earlier)} %" if score.earlier is not None else ""
            click.echo(
                f"  {shown.get(score.model, score.model)}: {format_percent(score.fresh)} %, "
                f"equated {format_percent(value.value)} %{interval}{there}"
                f"{'; near chance, so equated too high' if score.is_near_chance else ''}"
            )
