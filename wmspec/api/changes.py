"""The tasks whose files have changed since a git revision."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

from wmspec.api.task import Task
from wmspec.core.diagnostics import WmsError


def changed_tasks(tasks: Iterable[Task], revision: str) -> tuple[Task, ...]:
    """Return the tasks of which a spec, library or asset has changed since HEAD left the history of a revision.

    Changes that are not committed count, and files that git does not know and does not ignore. A library outside of
    the repositories of the specs never counts as changed. Raises WmsError with the reason of git.
    """
    if revision.startswith("-"):
        raise WmsError(f"--changed-since {revision}: expected a git revision, such as origin/main")
    repository = cache(lambda folder: Path(_git(folder, "rev-parse", "--show-toplevel").removesuffix("\n")).resolve())
    changed_files = cache(lambda top: _changed_files(top, revision))

    def concerned(task: Task) -> bool:
        """Whether a file of the task has changed; a text without a file counts as changed."""
        if task.path is None:
            return True
        changed = changed_files(repository(task.path.resolve().parent))
        return any(path.resolve() in changed for path in (task.path, *task.libraries, *task.assets))

    return tuple(filter(concerned, tasks))


def _changed_files(repository: Path, revision: str) -> frozenset[Path]:
    commit = f"{revision}^{{commit}}"
    _git(repository, "rev-parse", "--verify", "--quiet", "--end-of-options", commit, revision=revision)
    base = _git(repository, "merge-base", revision, "HEAD", revision=revision).strip()
    changed = _git(repository, "diff", "--name-only", "--no-renames", "--no-ext-diff", "-z", base)
    unknown = _git(repository, "ls-files", "--others", "--exclude-standard", "-z")
    return frozenset((repository / name).resolve() for name in (changed + unknown).split("\0") if name)


def _git(folder: Path, *arguments: str, revision: str = "") -> str:
    """Return the output of git. Raises WmsError if it fails, with the `revision` that it concerns."""
    command: Sequence[str] = ("git", "-C", str(folder), *arguments)
    try:
        done = subprocess.run(command, capture_output=True, check=False, encoding="utf-8", errors="surrogateescape")
    except OSError as error:
        raise WmsError(f"--changed-since needs git, which cannot be started: {error.strerror}") from None
    if done.returncode == 0:
        return done.stdout
    reason = done.stderr.strip().removeprefix("fatal: ")
    if revision and not reason:
        known = "no commit of this name" if arguments[0] == "rev-parse" else "no common history with HEAD"
        remedy = "fetch the history; for actions/checkout, set `fetch-depth: 0`"
        raise WmsError(f"--changed-since {revision}: this clone has {known}", help=remedy)
    raise WmsError(f"--changed-since: git fails in {folder}: {reason}")
