"""`wmspec audit`: check a dataset for shortcuts and other defects."""

from __future__ import annotations

import json
import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmspec.api.progress import progress_bar
from wmspec.cli.common import json_option, make_folder, write_text

if TYPE_CHECKING:
    from wmspec.dataset.audit.model import Audit

#: The most failures of one check that are printed.
MAX_PRINTED = 3


@click.command("audit")
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option("--output", "-o", type=click.Path(path_type=Path), help="Folder for audit.html and audit.json.")
@click.option(
    "--max-images",
    type=click.IntRange(20),
    default=2000,
    show_default=True,
    help="Maximum number of instances per task whose pictures are examined.",
)
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@json_option
@click.pass_context
def audit_command(
    ctx: click.Context, dataset: Path, output: Path | None, max_images: int, workers: int | None, as_json: bool
) -> None:
    """Audit a dataset for missing items, imbalance, duplicates and shortcuts.

    Exits with 1 if a check fails.
    """
    # Before the import of NumPy: one thread gives the same sums on any number of cores, and the matrices are small.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from wmspec.dataset.audit.audit import audit
    from wmspec.dataset.audit.model import FORMAT
    from wmspec.dataset.audit.page import page
    from wmspec.dataset.build.reader import DatasetReader
    from wmspec.eval.clips.audit import film_findings

    with progress_bar(len(DatasetReader.open(dataset).tasks), "auditing", "tasks") as progress:
        result = audit(dataset, max_images, progress, workers or os.cpu_count() or 1, film_findings)
    values = {"format": FORMAT, "passed": result.passed, **asdict(result)}
    record = json.dumps(values, indent=1, ensure_ascii=False) + "\n"
    if output is not None:
        folder = make_folder(output)
        write_text(folder / "audit.json", record)
        written = write_text(folder / "audit.html", page(result))
    if as_json:
        click.echo(record, nl=False)
    else:
        _print(result)
        if output is not None:
            click.echo(written)
    ctx.exit(0 if result.passed else 1)


def _print(result: Audit) -> None:
    """Print the overview and the failures."""
    from rich.console import Console
    from rich.table import Table

    from wmspec.dataset.audit.page import WORDS, overview, verdict

    colors = {"fail": "red", "unknown": "yellow", "pass": "green"}
    head, *lines = overview(result)
    table = Table(*head, box=None, pad_edge=False)
    for line in lines:
        table.add_row(line[0], f"[{colors[line[1]]}]{line[1]}[/]", *line[2:])
    Console(width=None if sys.stdout.isatty() else 160, soft_wrap=True).print(table)
    failing: dict[tuple[str, str], list[str]] = {}
    for finding in result.findings:
        if finding.verdict == "fails":
            failing.setdefault((finding.check, finding.task), []).append(finding.what)
    for (check, task), found in failing.items():
        for text in found[:MAX_PRINTED]:
            click.echo(f"{click.style(WORDS['fails'], fg='red')}: {check}{f' {task}' if task else ''}: {text}")
        if len(found) > MAX_PRINTED:
            click.echo(f"  and {len(found) - MAX_PRINTED:,} more; `-o FOLDER` writes all of them")
    click.echo(verdict(result))
