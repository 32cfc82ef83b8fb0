"""`wmspec list`: what is in these specs?"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from wmspec.cli.common import dimension_option, json_option, load_tasks, of_dimensions


@click.command("list")
@click.argument("specs", nargs=-1, type=click.Path(path_type=Path))
@dimension_option
@json_option
def list_command(specs: tuple[Path, ...], only_dimension: tuple[str, ...], as_json: bool) -> None:
    """List tasks with their dimensions, factors and numbers of instances (× questions), beside the paper's cases.

    Groups share every draw: their number is the sample size that nuisances have, and factors that are not crossed.

    Without SPECS: the tasks that come with wmspec.
    """
    from wmspec.parse.load import library_folder

    tasks = of_dimensions(load_tasks(specs or [library_folder().parent]), only_dimension)
    found = [_row(path, spec) for path, spec in tasks]
    if as_json:
        click.echo(json.dumps(found, indent=2))
    else:
        _print(found)


def _row(path: Path, spec: Any) -> dict[str, Any]:
    from wmspec.ask.views import views_of
    from wmspec.check.ir import Choices
    from wmspec.design.design import Design
    from wmspec.layout.values import Values
    from wmspec.paper import column
    from wmspec.stage.agents import executable

    design, there = Design(spec), column(spec.name)
    first = design[0]
    return {
        "task": spec.name,
        "dimension": spec.dimension,
        "title": spec.title,
        "instances": len(design),
        "images": len(views_of(spec, Values(spec, first.values, None, first.key))),
        "paper": None if there is None else {"task": there.name, "instances": there.cases, "images": there.images},
        "design": spec.plan.kind,
        "groups": design.draws,
        "factors": {f.name: len(f.domain.values) if isinstance(f.domain, Choices) else None for f in design.factors},
        "nuisances": [n.name for n in design.nuisances],
        "questions": len(spec.questions),
        "executable": executable(spec),
        "file": str(path),
    }


def _print(found: Sequence[dict[str, Any]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    numbers = ("instances", "groups", "paper's")
    for name in ("task", "dimension", *numbers, "factors"):
        table.add_column(name, justify="right" if name in numbers else "left", overflow="fold")
    for row in found:
        paper = f"{row['paper']['instances']:,}" if row["paper"] else "–"
        factors = ", ".join(f"{name} ({count or 'continuous'})" for name, count in row["factors"].items())
        asked = f" × {row['questions']}" if row["questions"] > 1 else ""
        name = row["task"] if row["executable"] else f"{row['task']} *"
        table.add_row(name, row["dimension"], f"{row['instances']:,}{asked}", f"{row['groups']:,}", paper, factors)
    console = Console()
    if not console.is_terminal:  # programs read lines: one a task, however long
        console.width = 10_000
    console.print(table)
    if not all(row["executable"] for row in found):
        console.print("* robots act in these: they are checked, and cannot be executed yet", highlight=False)
    console.print(_covered(found), highlight=False)


def _covered(found: Sequence[dict[str, Any]]) -> str:
    """How much of the paper these tasks rebuild."""
    from wmspec.paper import COLUMNS

    total, rebuilt = sum(c.cases for c in COLUMNS), [row["paper"] for row in found if row["paper"]]
    instances = sum(row["instances"] for row in found)
    return (
        f"{instances:,} instances; of the paper's {len(COLUMNS)} tasks and {total:,} instances, these rebuild "
        f"{len(rebuilt)} and {sum(there['instances'] for there in rebuilt):,}"
    )
