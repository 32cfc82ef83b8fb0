"""The command line. Each command is a module, imported on use."""

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
from typing import Any, NoReturn

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
    "import-arm",
    "things",
    "compile",
    "schema",
    "run",
    "render",
    "generate",
    "crosscheck",
    "verify",
    "attest",
    "view",
    "audit",
    "evaluate",
    "study",
    "report",
    "export",
    "submit",
    "score",
    "leaderboard",
    "import",
    "import-images",
    "conformance",
    "doctor",
)

#: Modules of commands whose names are words of Python.
MODULES = {"import": "import_benchmark"}

#: Former command name -> current name.
RENAMED_COMMANDS = {
    "arm": "import-arm",
    "conform": "conformance",
    "recast": "import-images",
    "seal": "attest",
}
#: Former option -> current option, of any command.
RENAMED_OPTIONS = {
    "--only-dimension": "--dimension",
    "--pictures-of": "--max-images",
    "--redrawn": "--redraw",
}
#: Exit code when the reader of a pipe is gone, as in `wmspec list | head`; that of SIGPIPE.
CLOSED_PIPE = 128 + 13
#: Exit code after Ctrl-C; that of SIGINT.
INTERRUPTED = 128 + 2
#: The end of `wmspec --help`.
EXIT_CODES = """\b
Exit codes:
  0    done
  1    bad outcome: nothing was made, too much failed, a check found differences
  2    invalid input or usage
  70   an internal error; WMSPEC_TRACEBACK=1 shows its traceback
  130  stopped by Ctrl-C
  141  the reader of a pipe is gone
"""


#: The signals that ended the run.
_received: list[int] = []


def _exit_on_signal(number: int, frame: FrameType | None) -> None:
    """Raise SystemExit."""
    if _is_importing(frame):
        return _send_again(number)
    _received.append(number)
    raise SystemExit(128 + number)


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt once; ignore Ctrl-C during the shutdown, which takes seconds with Ray."""
    if _is_importing(frame):
        return _send_again(number)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _received.append(number)
    raise KeyboardInterrupt


def _is_importing(frame: FrameType | None) -> bool:
    """Whether a module is being imported: USD prints and drops what a handler raises then, and the run would go on."""
    while frame is not None and frame.f_code.co_filename != "<frozen importlib._bootstrap>":
        frame = frame.f_back
    return frame is not None


def _send_again(number: int) -> None:
    """Send the signal again a little later."""
    later = threading.Timer(0.05, os.kill, (os.getpid(), number))
    later.daemon = True
    later.start()


def _report_thread_error(arguments: threading.ExceptHookArgs) -> None:
    """Report an exception that a thread did not catch like any unexpected error."""
    from wmspec.core import crash

    if arguments.exc_value is not None and not isinstance(arguments.exc_value, SystemExit):
        crash.tell(arguments.exc_value)


def _open_streams() -> None:
    """Open the standard streams that are closed; otherwise the next opened file would take their descriptors."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(descriptor)
    sys.stdin = sys.stdin or open(0, encoding="utf-8", closefd=False)  # noqa: SIM115  open until the process ends
    sys.stdout = sys.stdout or open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = sys.stderr or open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115


def _drop_streams() -> None:
    """Redirect stdout and stderr to the null device, so that flushing them at exit cannot fail."""
    for stream in (sys.stdout, sys.stderr):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class _Commands(click.Group):
    """A group that imports commands by module name; a user's mistake is one error line and exit code 2."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """Run as a process: `wmspec ...`."""
        # Objects created at start-up live until the end; the default threshold of 700 costs 10 % of the start-up time.
        gc.set_threshold(100_000, 20, 20)
        # Skip the collection at exit: another 10 %.
        atexit.register(gc.freeze)
        _open_streams()
        threading.excepthook = _report_thread_error
        # On SIGTERM, exit through `finally` blocks, which stop the workers and free shared memory.
        signal.signal(signal.SIGTERM, _exit_on_signal)
        if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:  # ignored in background jobs
            signal.signal(signal.SIGINT, _interrupt)
        try:
            return super().__call__(*arguments, **options)
        except OSError as error:  # such as a full disk
            file = f"{error.filename}: " if error.filename else ""
            with suppress(OSError):
                click.echo(f"error: {file}{error.strerror or error}", err=True)
            _drop_streams()
            sys.exit(2)
        except Exception as error:  # noqa: BLE001  users see no traceback
            if _received:  # a library has turned the signal's exception into its own
                sys.exit(128 + _received[0])
            from wmspec.core import crash

            with suppress(OSError):
                crash.tell(error)
            sys.exit(crash.EXIT_CODE)

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002  click passes it by name
        return [*COMMANDS]  # `list` is the module of that command, once it is imported

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command. Raises WmsError with the current or a similar name if it is unknown."""
        if args and (current := RENAMED_COMMANDS.get(args[0])):
            raise WmsError(f"`wmspec {args[0]}` is now `wmspec {current}`")
        if args and not args[0].startswith("-") and args[0] not in COMMANDS:
            raise WmsError(f"unknown command `{args[0]}`", help=suggestion(args[0], COMMANDS) or "see `wmspec --help`")
        return super().resolve_command(ctx, args)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        if cmd_name not in COMMANDS:
            return None
        name = MODULES.get(cmd_name, cmd_name.replace("-", "_"))
        module = importlib.import_module(f"wmspec.cli.{name}")
        command: click.Command = getattr(module, f"{name}_command")
        return command

    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except click.NoSuchOption as error:
            if error.option_name not in RENAMED_OPTIONS:
                raise
            self._fail(ctx, WmsError(f"`{error.option_name}` is now `{RENAMED_OPTIONS[error.option_name]}`"))
        except WmsError as error:
            self._fail(ctx, error)
        except KeyboardInterrupt:
            click.echo("\nstopped", err=True)
            ctx.exit(INTERRUPTED)
        except BrokenPipeError:
            _drop_streams()
            ctx.exit(CLOSED_PIPE)

    @staticmethod
    def _fail(ctx: click.Context, error: WmsError) -> NoReturn:
        from wmspec.cli.common import paint
        from wmspec.lang.parse.load import with_source_text

        click.echo(WmsError.of(with_source_text(error.diagnostics)).render(paint()), err=True)
        ctx.exit(2)


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]}, epilog=EXIT_CODES)
@click.version_option(__version__, prog_name="wmspec")
def main() -> None:
    """Controlled visual questions about physical worlds.

    A spec (.wms) describes objects, factors, actions and counterfactuals. It compiles to USD stages. Physics engines
    execute and render them; answers of the questions are measured.
    """
