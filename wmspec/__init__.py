"""wmspec: controlled visual questions about physical worlds, from a small language.

`wmspec.api` defines the public names; they are available here too: `wmspec.load`, `wmspec.crosscheck`,
`wmspec.generate`.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

__version__ = "0.2.0"

_ROOT = Path(__file__).parent
if not (_ROOT / "grammar").is_dir():  # a checkout has these folders beside wmspec/, an installed wheel inside it
    __path__.append(str(_ROOT.parent))

if TYPE_CHECKING:
    from wmspec.api import *  # noqa: F403


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("wmspec.api"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *import_module("wmspec.api").HOMES])
