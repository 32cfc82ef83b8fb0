"""`wmspec list`: list tasks."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmspec.cli.common import balance_note, by_size, dimension_option, json_option, tell

if TYPE_CHECKING:
    from wmspec.api import Task


@click.command("list")
@click.argument("specs", nargs=-1, type=click.Path(path_type=Path))
@dimension_option
@click.option("--sizes", is_flag=True, help="Print the number of independent groups per factor and nuisance.")
@json_option
def list_command(specs: tuple[Path, ...], dimension: tuple[str, ...], sizes: bool, as_json: bool) -> None:
    """List tasks: dimensions, factors, numbers of instances (× questions), and the paper's numbers of cases.

    Instances of a group share all random values, so the sample size is the number of groups. `color (3 in 60)` is a
    factor with three levels that is crossed in 60 groups. `--sizes` includes nuisances.

    Without SPECS: the tasks of WM-ABench. `wmspec list specs/gallery` and `specs/paradigms` list further shipped tasks.
    """
    from wmspec.api import load_all
    from wmspec.api.loading import filter_dimensions

    rows = [_row(task) for task in filter_dimensions(load_all(*specs, tell=tell), dimension)]
    if as_json:
        click.echo(json.dumps(rows, indent=2))
    else:
        _print(rows, sizes)


def _row(task: Task) -> dict[str, Any]:
    there = task.paper
    return {
        "task": task.name,
        "dimension": task.dimension,
        "title": task.title,
        "instances": len(task),
        "images": task.images,
        "paper": None if there is None else {"task": there.name, "instances": there.cases, "images": there.images},
        "design": task.spec.plan.kind,
        "groups": task.groups,
        "sample_sizes": task.sample_sizes,
        "balance": task.spec.plan.balance or None,
        "factors": {f.name: None if f.values is None else len(f.values) for f in task.factors},
        "nuisances": [n.name for n in task.nuisances],
        "questions": task.questions,
        "file": task.file,
    }


def _print(rows: Sequence[dict[str, Any]], sizes: bool) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    numbers = ("instances", "groups", "paper's")
    last = "independent groups" if sizes else "factors"
    for name in ("task", "dimension", *numbers, last):
        table.add_column(name, justify="right" if name in numbers else "left", overflow="fold")
    for row in rows:
        paper = f"{row['paper']['instances']:,}" if row["paper"] else "–"
        per_instance = f" × {row['questions']}" if row["questions"] > 1 else ""
        count, factors = f"{row['instances']:,}{per_instance}", _sizes(row) if sizes else _factors(row)
        table.add_row(row["task"], row["dimension"], count, f"{row['groups']:,}", paper, factors)
    console = Console()
    if not console.is_terminal:  # one line per task for programs
        console.width = 10_000
    console.print(table)
    for row in rows:
        if row["balance"]:
            console.print(f"{row['task']}: {balance_note(row['balance'])}", highlight=False)
    console.print(_coverage(rows), highlight=False)


def _sizes(row: dict[str, Any]) -> str:
    """Return the factors and nuisances, grouped by their number of groups."""
    return "; ".join(f"{size:,}: {', '.join(names)}" for size, names in by_size(row["sample_sizes"]).items())


def _factors(row: dict[str, Any]) -> str:
    """Return the number of levels per factor, and the number of groups that cross it if not all."""
    sizes = {name: row["sample_sizes"][name] for name in row["factors"]}
    crossed = {name: "" if size == row["groups"] else f" in {size:,}" for name, size in sizes.items()}
    return ", ".join(f"{name} ({count or 'continuous'}{crossed[name]})" for name, count in row["factors"].items())


def _coverage(rows: Sequence[dict[str, Any]]) -> str:
    """Return the totals, and how much of WM-ABench the tasks cover."""
    from wmspec.core.wm_abench import COLUMNS

    total, rebuilt = sum(c.cases for c in COLUMNS), [row["paper"] for row in rows if row["paper"]]
    instances, groups = sum(row["instances"] for row in rows), sum(row["groups"] for row in rows)
    covered = f"{instances:,} instances in {groups:,} groups"
    if not rebuilt:
        return covered
    return (
        f"{covered}; of the paper's {len(COLUMNS)} tasks and {total:,} instances, these rebuild "
        f"{len(rebuilt)} and {sum(there['instances'] for there in rebuilt):,}"
    )
