"""Paths of the files that wmspec ships: grammar, specs, templates."""

from __future__ import annotations

from pathlib import Path

import wmspec


def resource(path: str) -> Path:
    """Return the path of a shipped file or folder such as `grammar/wms.lark`, in a checkout and in an installed wheel.

    Raises FileNotFoundError if it is missing.
    """
    for root in wmspec.__path__:
        if (place := Path(root) / path).exists():
            return place
    raise FileNotFoundError(f"{path} is missing from this installation of wmspec")
