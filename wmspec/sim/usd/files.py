"""Opens USD files and translates USD's errors."""

from __future__ import annotations

from pathlib import Path

from pxr import Tf, Usd

from wmspec.core.diagnostics import WmsError
from wmspec.sim.usd.composed import require_bounded


def open_stage_file(path: Path, shown: str) -> Usd.Stage:
    """Return the stage of a file in its current state on disk. Callers suppress USD's own output.

    Raises: WmsError: with USD's complaint, where the file is called `shown`; or because the stage is too large.
    """
    try:
        require_bounded(path)
        stage = Usd.Stage.Open(str(path))
        stage.Reload()  # USD caches layers; reload what changed on disk
    except Tf.ErrorException as error:
        raise WmsError(_complaint(error, path, shown)) from None
    return stage


def error_text(error: object) -> str:
    """Return USD's message, which may quote a file that is not text."""
    try:
        return str(error)
    except UnicodeDecodeError:
        return "it is damaged"


def complaint(error: object) -> str:
    """Return USD's first message, without places in its source."""
    return error_text(error).partition(" : '")[2].partition("'\n")[0][:300] or "it is damaged"


def _complaint(error: Exception, path: Path, shown: str) -> str:
    """Return pxr's first complaint about a file, called `shown`, without places in pxr's source."""
    text = error_text(error).partition(" : '")[2].partition("'\n")[0] or error_text(error) or type(error).__name__
    for name in (f"<{path.resolve()}>", str(path.resolve())):
        text = text.replace(name, shown)
    return " ".join(text.replace("</", "<").split())[: 120 + len(shown)]
