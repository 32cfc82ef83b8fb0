"""Unexpected errors: one line on the terminal, and a file with the details."""

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
from importlib.metadata import PackageNotFoundError, metadata, requires
from pathlib import Path

from wmspec.core.code_digest import installed_version
from wmspec.core.diagnostics import escape_controls

#: Exit code of a command after an unexpected error: EX_SOFTWARE of sysexits.h.
EXIT_CODE = 70
#: Environment variable that makes commands print the traceback.
VARIABLE = "WMSPEC_TRACEBACK"
#: The packages of wmspec.
PACKAGES = ("wmspec", "backends")
#: Exceptions that Python raises for programming errors, independent of the machine.
MISTAKES = (ArithmeticError, AssertionError, AttributeError, ImportError, LookupError, NameError, TypeError)


@dataclass(frozen=True)
class Crash:
    """An unexpected error: type and message, innermost place, both in one short line, and the traceback.

    `line` is equal in every run; it names the innermost place in the code of wmspec.
    """

    summary: str
    place: str
    line: str
    traceback: str

    @classmethod
    def of(cls, error: BaseException, skip: int = 0) -> Crash:
        """Return the crash of an exception; its traceback omits the first `skip` frames."""
        way = list(traceback.walk_tb(error.__traceback__))[skip:]
        ours = [step for step in way if step[0].f_globals.get("__name__", "").split(".")[0] in PACKAGES]
        kind, message = type(error).__name__, str(error)
        short = re.sub(r"0x[0-9a-f]{6,}", "0x...", " ".join(message.split()))[:300]
        place = f" ({_place(*ours[-1])})" if ours else ""
        return cls(
            summary=f"{kind}: {message}" if message else kind,
            place=_place(*way[-1]) if way else "",
            line=f"{kind}: {short}{place}",
            traceback="".join(traceback.format_exception(error)),
        )

    def report(self) -> str:
        """Return the text for a terminal: type and message, the file with the details, how to report it."""
        return f"{escape_controls(self.summary)}\n{self.advice(self.save())}"

    def advice(self, path: Path | None) -> str:
        """Return the place, the file with the details, and how to report it, one line each."""
        lines = [f"  at {self.place}"] if self.place else []
        lines.append(f"  details: {path}" if path else "  the details could not be written to a file")
        return "\n".join([*lines, f"  {how_to_report(path is not None)}"])

    def save(self) -> Path | None:
        """Write the details to the user's cache, else to the temporary folder, and return the file.

        The same error of the same command has the same file. None if no file can be written.
        """
        content = "\n\n".join([_environment(), self.traceback])
        name = f"error-{hashlib.sha256(content.encode()).hexdigest()[:12]}.txt"
        for folder in (_cache, lambda: Path(tempfile.mkdtemp(prefix="wmspec-"))):
            try:
                path = folder() / name
                path.write_text(content, encoding="utf-8", errors="backslashreplace")
            except (OSError, RuntimeError):  # no such folder; no home
                continue
            return path
        return None


def is_own_error(error: BaseException) -> bool:
    """Whether an exception is a mistake in wmspec: raised in its code, or by an import of a missing module of it."""
    if isinstance(error, ImportError):
        missing = error.name or ""
        if missing.split(".")[0] in PACKAGES:
            return True
        if not error.msg.startswith("cannot import name") and "." not in missing:
            return False  # a package or a system library is not there
    way = list(traceback.walk_tb(error.__traceback__))
    innermost = way[-1][0].f_globals.get("__name__", "") if way else ""
    return isinstance(error, MISTAKES) and innermost.split(".")[0] in PACKAGES


def how_to_report(file: bool = True) -> str:
    """Return how to report an error, with the address of the issue tracker if the package has one.

    With `file`, the text refers to the file with the details.
    """
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
    """Print an unexpected exception to standard error, or its traceback if VARIABLE is set."""
    if os.environ.get(VARIABLE):
        traceback.print_exception(error)
    else:
        print(f"error: {Crash.of(error).report()}", file=sys.stderr)


def _place(frame: object, line: int) -> str:
    """Return the last two parts of a file's path, and the line."""
    return f"{'/'.join(Path(frame.f_code.co_filename).parts[-2:])}:{line}"  # type: ignore[attr-defined]


def _cache() -> Path:
    root = os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()
    folder = Path(root, "wmspec", "errors")
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    return folder


def _environment() -> str:
    """Return the command line and the versions of Python, the system, wmspec and its requirements."""
    try:
        needed = sorted({re.split(r"[^\w.-]", one, maxsplit=1)[0] for one in requires("wmspec") or ()})
    except PackageNotFoundError:
        needed = []
    lines = [
        f"command: {shlex.join(sys.argv)}",
        f"Python {platform.python_version()} on {platform.platform()}",
        *(f"{name} {found}" for name in ("wmspec", *needed) if (found := installed_version(name))),
    ]
    return "\n".join(dict.fromkeys(lines))
