"""The command line in this process: a new one would import for seconds what is imported here."""

from __future__ import annotations

from contextlib import chdir
from pathlib import Path

from click.testing import CliRunner, Result

from wmspec.cli import main


def wmspec(*args: object, folder: Path, code: int = 0, **env: str) -> Result:
    """Run a command in a folder. An exception that nobody foresaw is raised, as a traceback would be."""
    with chdir(folder):
        done = CliRunner().invoke(main, list(map(str, args)), env=env)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == code, done.output
    return done
