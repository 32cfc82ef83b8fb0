"""`wmspec audit`: is a dataset what it promises?"""

from __future__ import annotations

import json
import os
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmspec.api.progress import progress_bar
from wmspec.cli.common import json_option, make_folder, write_text

if TYPE_CHECKING:
    from wmspec.audit.model import Audit, Verdict


@click.command("audit")
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option("--output", "-o", type=click.Path(path_type=Path), help="The folder for audit.html and audit.json.")
@click.option(
    "--pictures-of",
    type=click.IntRange(20),
    default=2000,
    show_default=True,
    help="Look at the pictures of at most so many instances of each task.",
)
@json_option
@click.pass_context
def audit_command(ctx: click.Context, dataset: Path, output: Path | None, pictures_of: int, as_json: bool) -> None:
    """Look for what is wrong with a dataset: missing, unbalanced, duplicated, or answered by a shortcut.

    Exit code 1 if anything fails.
    """
    # Before NumPy starts: its matrices are small here, and the same sums must come out on any number of cores.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from wmspec.audit.audit import audit
    from wmspec.audit.page import page
    from wmspec.write.reader import DatasetReader

    with progress_bar(len(DatasetReader.open(dataset).tasks), "auditing", "tasks") as progress:
        result = audit(dataset, pictures_of, progress)
    record = json.dumps({"passed": result.passed, **asdict(result)}, indent=1, ensure_ascii=False) + "\n"
    if output is not None:
        folder = make_folder(output)
        write_text(folder / "audit.json", record)
        written = write_text(folder / "audit.html", page(result))
    if as_json:
        click.echo(record, nl=False)
    else:
        _tell(result)
        if output is not None:
            click.echo(written)
    ctx.exit(0 if result.passed else 1)


def _tell(result: Audit) -> None:
    """What matters, for a terminal: what fails, and how much else there is to read."""
    from wmspec.audit.page import WORDS, verdict

    quiet: dict[Verdict, str] = {"unclear": "yellow", "told": "blue", "holds": "green"}
    for finding in result.findings:
        if finding.verdict == "fails":
            where = f" {finding.task}" if finding.task else ""
            click.echo(f"{click.style(WORDS['fails'], fg='red')}: {finding.check}{where}: {finding.what}")
    counted = Counter(finding.verdict for finding in result.findings)
    for kind, color in quiet.items():
        if counted[kind]:
            click.echo(f"{click.style(WORDS[kind], fg=color)}: {counted[kind]:,}")
    click.echo(verdict(result))
