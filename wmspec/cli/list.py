"""`wmspec list`: what is in these specs?"""

from __future__ import annotations

import json
from pathlib import Path

import click

from wmspec.cli.common import json_option, load_tasks


@click.command("list")
@click.argument("specs", nargs=-1, type=click.Path(path_type=Path))
@json_option
def list_command(specs: tuple[Path, ...], as_json: bool) -> None:
    """List tasks with their dimensions, factors and numbers of instances. Without SPECS: those of wmspec."""
    from wmspec.check.ir import Choices
    from wmspec.design.design import Design
    from wmspec.parse.load import library_folder

    found = []
    for path, spec in load_tasks(specs or [library_folder().parent]):
        design = Design(spec)
        levels = {f.name: len(f.domain.values) for f in design.factors if isinstance(f.domain, Choices)}
        found.append(
            {
                "task": spec.name,
                "dimension": spec.dimension,
                "title": spec.title,
                "instances": len(design),
                "factors": levels,
                "nuisances": [n.name for n in design.nuisances],
                "questions": len(spec.questions),
                "file": str(path),
            }
        )
    if as_json:
        click.echo(json.dumps(found, indent=2))
        return
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("task", "dimension", "instances", "factors"):
        table.add_column(column, justify="right" if column == "instances" else "left", overflow="fold")
    for row in found:
        factors = row["factors"]
        assert isinstance(factors, dict)
        table.add_row(
            str(row["task"]),
            str(row["dimension"]),
            f"{row['instances']:,}",
            ", ".join(f"{n} ({c})" for n, c in factors.items()),
        )
    Console(soft_wrap=False).print(table)
