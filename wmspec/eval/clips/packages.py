"""The optional packages of this room."""

from __future__ import annotations

from typing import Any

from wmspec.core.diagnostics import WmsError


def opencv() -> Any:
    """Return the module `cv2`, with one thread. Raises WmsError if it is not installed."""
    try:
        import cv2
    except ImportError:
        raise WmsError("scoring clips needs OpenCV", help="install it with `pip install 'wmspec[clips]'`") from None
    cv2.setNumThreads(1)
    return cv2
