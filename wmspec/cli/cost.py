"""Cost estimates of `wmspec generate --dry-run`."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from wmspec.api.progress import progress_bar
from wmspec.cli.common import exit_if_failed
from wmspec.core.tally import Tally

if TYPE_CHECKING:
    from wmspec.dataset.build.estimate import Cost
    from wmspec.dataset.build.plan import Plan
    from wmspec.runtime.workers.pool import PoolConfig


def print_cost(plan: Plan, effort: PoolConfig, as_json: bool) -> None:
    """Generate some instances per task and print a cost estimate. Exits with 1 if too many failed."""
    from wmspec.dataset.build.estimate import estimate
    from wmspec.dataset.build.manifest import top_reasons

    with progress_bar(len(plan.tasks), "trying", "tasks") as progress:
        costs = estimate(plan, effort, progress)
    if as_json:
        rows = [
            {name: value for name, value in asdict(c).items() if name != "crash"}
            | {"hours": c.hours(effort.workers), "bytes": c.bytes}
            for c in costs
        ]
        click.echo(json.dumps({"workers": effort.workers, "tasks": rows}, indent=2))
    else:
        _print(costs, effort.workers)
        for cost in costs:
            if cost.reasons:
                click.echo("\n".join([f"{cost.task}:", *top_reasons(cost.reasons, cost.examples).values()]))
            if cost.balance is not None:
                click.echo(f"{cost.task}: {cost.balance}")
        click.echo(f"with {effort.workers} workers, in {', '.join(plan.engines)}; nothing was written")
        click.echo("± is one standard error, from the variation among the tried units")
    exit_if_failed(_tally(costs))


def _tally(costs: Sequence[Cost]) -> Tally:
    """Return the counts of a dry run; rejections by gates are not failures."""
    tried, failed = sum(c.tried for c in costs), sum(c.failed for c in costs)
    crash = next((c.crash for c in costs if c.crash is not None), None)
    return Tally("instance was tried", tried, "instances", tried, failed, crash.report() if crash else "")


def _print(costs: Sequence[Cost], workers: int) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("task", "instances", "time", "size", "tried", "s each", "rejected"):
        table.add_column(name, justify="left" if name == "task" else "right", overflow="fold")
    for c in costs:
        table.add_row(
            c.task, *_totals([c], workers), f"{c.tried}", f"{c.seconds:.2f}", f"{c.rejected} of {c.questions}"
        )
    if len(costs) > 1:
        table.add_row("total", *_totals(costs, workers))
    Console(soft_wrap=False).print(table, highlight=False)


def _totals(costs: Sequence[Cost], workers: int) -> tuple[str, str, str]:
    """Return instances, time with its standard error, and size."""
    hours, count = sum(c.hours(workers) for c in costs), sum(c.bytes for c in costs)
    errors = [error for c in costs if (error := c.standard_error(workers)) is not None]
    within = f" ± {math.hypot(*errors) / hours:.0%}" if len(errors) == len(costs) and hours else ""
    return f"{sum(c.instances for c in costs):,}", _duration(hours) + within, _size(count)


def _duration(hours: float) -> str:
    if hours < 1 / 30:
        return f"{hours * 3600:.0f} s"
    return f"{hours * 60:.0f} min" if hours < 2 else f"{hours:.1f} h"


def _size(count: float) -> str:
    return f"{count / 1e9:.1f} GB" if count >= 1e9 else f"{count / 1e6:.1f} MB"
