"""Unexpected errors: one line for the terminal, and a file with everything that helps to explain them."""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shlex
import sys
import tempfile
import traceback
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, metadata, requires, version
from pathlib import Path

from wmspec.core.diagnostics import visible

#: The exit code of a command that met one: EX_SOFTWARE of sysexits.h.
EXIT_CODE = 70
#: The environment variable that lets a command show the traceback.
VARIABLE = "WMSPEC_TRACEBACK"
#: The packages that are ours.
OURS = ("wmspec", "backends")
#: What Python raises for a mistake in code, whatever the machine.
MISTAKES = (ArithmeticError, AssertionError, AttributeError, ImportError, LookupError, NameError, TypeError)


@dataclass(frozen=True)
class Crash:
    """An unexpected error: its type and message, the innermost place, the same in one short line, and the traceback.

    `line` is the same in every run; it names the innermost place in our own code.
    """

    summary: str
    place: str
    line: str
    traceback: str

    @classmethod
    def of(cls, error: BaseException, skip: int = 0) -> Crash:
        """The crash that an exception is; its traceback begins after `skip` frames."""
        way = list(traceback.walk_tb(error.__traceback__))[skip:]
        ours = [step for step in way if step[0].f_globals.get("__name__", "").split(".")[0] in OURS]
        kind, message = type(error).__name__, str(error)
        short = re.sub(r"0x[0-9a-f]{6,}", "0x...", " ".join(message.split()))[:300]
        place = f" ({_place(*ours[-1])})" if ours else ""
        return cls(
            summary=f"{kind}: {message}" if message else kind,
            place=_place(*way[-1]) if way else "",
            line=f"{kind}: {short}{place}",
            traceback="".join(traceback.format_exception(error)),
        )

    def told(self) -> str:
        """What a terminal shows: type and message in full, the file with the rest, how to report it."""
        return f"{visible(self.summary)}\n{self.advice(self.save())}"

    def advice(self, path: Path | None) -> str:
        """The place, the file with the full text, and how to report it, a line each."""
        lines = [f"  at {self.place}"] if self.place else []
        lines.append(f"  the full text: {path}" if path else "  the full text could not be written anywhere")
        return "\n".join([*lines, f"  {how_to_report(path is not None)}"])

    def save(self) -> Path | None:
        """Write the full text, and return its file: in the user's cache, else in the temporary folder.

        The same error of the same command has the same file. None if no file can be written.
        """
        content = "\n\n".join([_circumstances(), self.traceback])
        name = f"error-{hashlib.sha256(content.encode()).hexdigest()[:12]}.txt"
        for folder in (_cache, _temporary):
            try:
                path = folder() / name
                path.write_text(content, encoding="utf-8", errors="backslashreplace")
            except (OSError, RuntimeError):  # no such folder; no home
                continue
            return path
        return None


def in_our_code(error: BaseException) -> bool:
    """Whether an exception is a mistake in our code: raised in one of our own lines, or a module of ours is missing."""
    if isinstance(error, ImportError):
        missing = error.name or ""
        if missing.split(".")[0] in OURS:
            return True
        if not error.msg.startswith("cannot import name") and "." not in missing:
            return False  # a package or a system library is not there
    way = list(traceback.walk_tb(error.__traceback__))
    innermost = way[-1][0].f_globals.get("__name__", "") if way else ""
    return isinstance(error, MISTAKES) and innermost.split(".")[0] in OURS


def how_to_report(file: bool = True) -> str:
    """How to report an error, with its `file`; with the address of the issue tracker if the package names one."""
    try:
        urls = dict(entry.split(", ", 1) for entry in metadata("wmspec").get_all("Project-URL") or () if ", " in entry)
    except PackageNotFoundError:
        urls = {}
    tracker = next((url for name, url in urls.items() if name.lower() in ("issues", "bug tracker", "tracker")), "")
    where = f"at {tracker}" if tracker else "as an issue in the repository of wmspec"
    return f"this is a mistake in wmspec or in an engine; please report it {where}" + (
        ", with that file" if file else ""
    )


def tell(error: BaseException) -> None:
    """Print an unexpected exception on standard error: message and file, or the traceback if VARIABLE is set."""
    if os.environ.get(VARIABLE):
        traceback.print_exception(error)
    else:
        print(f"error: {Crash.of(error).told()}", file=sys.stderr)


def _place(frame: object, line: int) -> str:
    """The last two parts of a file's path, and the line."""
    return f"{'/'.join(Path(frame.f_code.co_filename).parts[-2:])}:{line}"  # type: ignore[attr-defined]


def _cache() -> Path:
    root = os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()
    folder = Path(root, "wmspec", "errors")
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    return folder


def _temporary() -> Path:
    return Path(tempfile.mkdtemp(prefix="wmspec-"))


def _circumstances() -> str:
    """The command line, the versions of Python, of the system, of wmspec and of what it requires."""
    try:
        needed = sorted({re.split(r"[^\w.-]", one, maxsplit=1)[0] for one in requires("wmspec") or ()})
    except PackageNotFoundError:
        needed = []
    lines = [
        f"command: {shlex.join(sys.argv)}",
        f"Python {platform.python_version()} on {platform.platform()}",
        *(f"{name} {found}" for name in ("wmspec", *needed) if (found := _version(name))),
    ]
    return "\n".join(dict.fromkeys(lines))


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""
