"""Where the files that come with wmspec are: the grammar and the library of specs."""

from __future__ import annotations

from pathlib import Path

import wmspec


def resource(path: str) -> Path:
    """A file or folder that comes with wmspec, such as `grammar/wms.lark`, in a checkout as in an installed wheel.

    Raises FileNotFoundError if there is none.
    """
    for root in wmspec.__path__:
        if (place := Path(root) / path).exists():
            return place
    raise FileNotFoundError(f"{path} did not come with this installation of wmspec")
