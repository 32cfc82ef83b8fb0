"""How far something long has come."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from time import monotonic

#: Where there is no terminal, so many seconds pass at most without a word.
QUIET = 300.0

#: Told the task and how many more of its instances are finished.
Advance = Callable[[str, int], None]

#: Begins to show progress: of so many instances, and what is done with them.
Progress = Callable[[int, str], AbstractContextManager[Advance]]


@contextmanager
def silent(total: int, doing: str) -> Iterator[Advance]:  # noqa: ARG001  as `Progress` has it
    """Show nothing."""
    yield lambda task, count: None  # noqa: ARG005


@contextmanager
def progress_bar(total: int, doing: str, what: str = "instances") -> Iterator[Callable[[str, int], None]]:
    """A progress bar on a terminal; elsewhere a line every tenth of the way, and every five minutes."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    done, told = 0, monotonic()
    if not console.is_terminal:

        def line(task: str, count: int) -> None:
            nonlocal done, told
            before, done = done, done + count
            if total and (before * 10 // total != done * 10 // total or monotonic() - told > QUIET):
                told = monotonic()
                console.print(f"{done} of {total} {what} ({task})", highlight=False)

        yield line
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console) as bar:
        shown = bar.add_task(doing, total=total)
        yield lambda task, count: bar.update(shown, description=task, advance=count)
