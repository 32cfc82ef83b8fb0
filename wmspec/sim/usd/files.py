"""USD files opened; what USD complains of is told by us."""

from __future__ import annotations

from pathlib import Path

from pxr import Tf, Usd

from wmspec.core.diagnostics import WmsError
from wmspec.sim.usd.composed import bounded


def opened(path: Path, shown: str) -> Usd.Stage:
    """The stage in a file, as it is there now. Whoever opens it keeps USD from printing meanwhile.

    Raises:
        WmsError: saying what USD complains of, where the file is called `shown`; or that the stage would be too large.
    """
    try:
        bounded(path)
        stage = Usd.Stage.Open(str(path))
        stage.Reload()  # of a layer that was read before, USD gives what was in it then
    except Tf.ErrorException as error:
        raise WmsError(_complaint(error, path, shown)) from None
    return stage


def text_of(error: object) -> str:
    """What USD says, which may quote a file that is not text."""
    try:
        return str(error)
    except UnicodeDecodeError:
        return "it is damaged"


def _complaint(error: Exception, path: Path, shown: str) -> str:
    """The first thing that pxr complains about a file, told as `shown`, without where in its own source."""
    complaint = text_of(error).partition(" : '")[2].partition("'\n")[0] or text_of(error) or type(error).__name__
    for name in (f"<{path.resolve()}>", str(path.resolve())):
        complaint = complaint.replace(name, shown)
    return " ".join(complaint.replace("</", "<").split())[: 120 + len(shown)]
