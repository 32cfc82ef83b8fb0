"""Progress of long operations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from time import monotonic

#: Without a terminal, the longest time between two lines, in seconds.
MAX_SILENCE = 300.0

#: Receives a task name and the number of newly finished instances.
Advance = Callable[[str, int], None]

#: Starts a progress display for a number of instances and a label.
Progress = Callable[[int, str], AbstractContextManager[Advance]]


@contextmanager
def silent(total: int, doing: str) -> Iterator[Advance]:  # noqa: ARG001  the signature of `Progress`
    """Show nothing."""
    yield lambda task, count: None  # noqa: ARG005


@contextmanager
def progress_bar(total: int, doing: str, what: str = "instances") -> Iterator[Callable[[str, int], None]]:
    """Show a progress bar on a terminal; otherwise print a line per tenth, and at least one every five minutes."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    done, last_line = 0, monotonic()
    if not console.is_terminal:

        def line(task: str, count: int) -> None:
            nonlocal done, last_line
            before, done = done, done + count
            if total and (before * 10 // total != done * 10 // total or monotonic() - last_line > MAX_SILENCE):
                last_line = monotonic()
                console.print(f"{done} of {total} {what} ({task})", highlight=False)

        yield line
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console) as bar:
        shown = bar.add_task(doing, total=total)
        yield lambda task, count: bar.update(shown, description=task, advance=count)
