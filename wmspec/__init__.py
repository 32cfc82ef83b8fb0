"""wmspec: controlled visual questions about a physical world, from one small language."""

from pathlib import Path

__version__ = "0.1.0"

_ROOT = Path(__file__).parent
if not (_ROOT / "grammar").is_dir():  # a checkout has these folders beside wmspec/, an installed wheel inside it
    __path__.append(str(_ROOT.parent))
