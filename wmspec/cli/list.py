"""`wmspec list`: what is in these specs?"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmspec.cli.common import dimension_option, json_option, tell

if TYPE_CHECKING:
    from wmspec.api import Task


@click.command("list")
@click.argument("specs", nargs=-1, type=click.Path(path_type=Path))
@dimension_option
@json_option
def list_command(specs: tuple[Path, ...], only_dimension: tuple[str, ...], as_json: bool) -> None:
    """List tasks with their dimensions, factors and numbers of instances (× questions), beside the paper's cases.

    Groups share every draw: their number is the sample size that nuisances have, and factors that are not crossed. A
    factor that takes turns is crossed in some of them: `color (3 in 60)`.

    Without SPECS: the tasks that rebuild the paper's. `wmspec list specs/gallery` lists others that come with wmspec.
    """
    from wmspec.api import load_all
    from wmspec.api.loading import of_dimensions

    rows = [_row(task) for task in of_dimensions(load_all(*specs, tell=tell), only_dimension)]
    if as_json:
        click.echo(json.dumps(rows, indent=2))
    else:
        _print(rows)


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


def _print(rows: Sequence[dict[str, Any]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    numbers = ("instances", "groups", "paper's")
    for name in ("task", "dimension", *numbers, "factors"):
        table.add_column(name, justify="right" if name in numbers else "left", overflow="fold")
    for row in rows:
        paper = f"{row['paper']['instances']:,}" if row["paper"] else "–"
        factors = ", ".join(f"{name} ({_levels(row, name)})" for name in row["factors"])
        asked = f" × {row['questions']}" if row["questions"] > 1 else ""
        table.add_row(
            row["task"], row["dimension"], f"{row['instances']:,}{asked}", f"{row['groups']:,}", paper, factors
        )
    console = Console()
    if not console.is_terminal:  # programs read lines: one a task, however long
        console.width = 10_000
    console.print(table)
    console.print(_covered(rows), highlight=False)


def _levels(row: dict[str, Any], factor: str) -> str:
    """How many values a factor has, and in how many groups it is crossed if that is not in all."""
    count, size = row["factors"][factor], row["sample_sizes"][factor]
    return f"{count or 'continuous'}" + (f" in {size:,}" if size != row["groups"] else "")


def _covered(rows: Sequence[dict[str, Any]]) -> str:
    """How much of the paper these tasks rebuild."""
    from wmspec.paper import COLUMNS

    total, rebuilt = sum(c.cases for c in COLUMNS), [row["paper"] for row in rows if row["paper"]]
    instances = sum(row["instances"] for row in rows)
    return (
        f"{instances:,} instances; of the paper's {len(COLUMNS)} tasks and {total:,} instances, these rebuild "
        f"{len(rebuilt)} and {sum(there['instances'] for there in rebuilt):,}"
    )
