"""The command line. Every command is a file of its own, imported when it is used."""

from __future__ import annotations

import atexit
import gc
import importlib
import os
import signal
import sys
import threading
from contextlib import suppress
from types import FrameType
from typing import Any

import click

from wmspec import __version__
from wmspec.core.diagnostics import WmsError, suggestion

COMMANDS = (
    "new",
    "check",
    "fmt",
    "watch",
    "lsp",
    "explain",
    "list",
    "arm",
    "compile",
    "schema",
    "run",
    "render",
    "generate",
    "crosscheck",
    "verify",
    "seal",
    "view",
    "audit",
    "evaluate",
    "study",
    "report",
    "export",
    "recast",
    "conformance",
    "doctor",
)


#: The exit code where the reader of a pipe has gone, as in `wmspec list | head`: as of what SIGPIPE ends.
CLOSED_PIPE = 128 + 13
#: That of what Ctrl-C ends.
INTERRUPTED = 128 + 2
#: What `wmspec --help` ends with.
EXIT_CODES = """\b
Exit codes:
  0    done
  1    it ran, and the outcome is bad: nothing was made, too much failed, a check found differences
  2    a mistake in what was asked for
  70   an internal error; WMSPEC_TRACEBACK=1 shows its traceback
  130  stopped by Ctrl-C
  141  the reader of a pipe has gone
"""


def _end(number: int, frame: FrameType | None) -> None:  # noqa: ARG001  a handler is called with both
    raise SystemExit(128 + number)


def _interrupt(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
    """Ctrl-C ends a run once: what ends, and Ray takes seconds to, is not ended again halfway."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    raise KeyboardInterrupt


def _of_thread(arguments: threading.ExceptHookArgs) -> None:
    """What a thread did not catch is told as all unexpected errors are."""
    from wmspec.core import crash

    if arguments.exc_value is not None and not isinstance(arguments.exc_value, SystemExit):
        crash.tell(arguments.exc_value)


def _open_streams() -> None:
    """Have all three streams: what is opened next would take the place of one that is closed, and be written into."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(descriptor)
    sys.stdin = sys.stdin or open(0, encoding="utf-8", closefd=False)  # noqa: SIM115  as long as the process
    sys.stdout = sys.stdout or open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = sys.stderr or open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115


def _drop_streams() -> None:
    """What is left in them has nowhere to go either."""
    for stream in (sys.stdout, sys.stderr):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class _Commands(click.Group):
    """Commands by file name; a user's mistake is told in a sentence and ends with exit code 2."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """Run as a process of its own: `wmspec ...`."""
        # Much is made while a command starts, and it stays: looking for garbage in it every 700 objects takes a tenth.
        gc.set_threshold(100_000, 20, 20)
        # Nor is anything worth finding when the process ends: another tenth.
        atexit.register(gc.freeze)
        _open_streams()
        threading.excepthook = _of_thread
        # Told to end, a run ends its workers first, and says nothing of what they share.
        signal.signal(signal.SIGTERM, _end)
        if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:  # as it is of jobs in the background
            signal.signal(signal.SIGINT, _interrupt)
        try:
            return super().__call__(*arguments, **options)
        except OSError as error:  # what nobody foresaw, such as that the disk is full to which the output goes
            file = f"{error.filename}: " if error.filename else ""
            with suppress(OSError):
                click.echo(f"error: {file}{error.strerror or error}", err=True)
            _drop_streams()
            sys.exit(2)
        except Exception as error:  # noqa: BLE001  a user sees no traceback of ours
            from wmspec.core import crash

            with suppress(OSError):
                crash.tell(error)
            sys.exit(crash.EXIT_CODE)

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002  click calls it by name
        return list(COMMANDS)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that is meant; of one that there is not, what may be meant."""
        if args and not args[0].startswith("-") and args[0] not in COMMANDS:
            raise WmsError(
                f"there is no command `{args[0]}`", help=suggestion(args[0], COMMANDS) or "see `wmspec --help`"
            )
        return super().resolve_command(ctx, args)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"wmspec.cli.{cmd_name}")
        command: click.Command = getattr(module, f"{cmd_name}_command")
        return command

    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except WmsError as error:
            from wmspec.cli.common import paint
            from wmspec.lang.parse.load import pointed

            click.echo(WmsError.of(pointed(error.diagnostics)).render(paint()), err=True)
            ctx.exit(2)
        except KeyboardInterrupt:
            click.echo("\nstopped", err=True)
            ctx.exit(INTERRUPTED)
        except BrokenPipeError:
            _drop_streams()
            ctx.exit(CLOSED_PIPE)


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]}, epilog=EXIT_CODES)
@click.version_option(__version__, prog_name="wmspec")
def main() -> None:
    """Controlled visual questions about a physical world.

    A spec (.wms) describes objects, factors, actions and counterfactuals. It compiles to a USD stage, which
    physics engines execute and draw; questions with measured answers come out.
    """
