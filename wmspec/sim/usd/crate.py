"""Binary USD files, read first in a separate process.

USD trusts the lengths in such files: a damaged one can crash the reader or fill its memory. Text files cannot.
"""

from __future__ import annotations

import subprocess
import sys
from functools import lru_cache
from pathlib import Path

from wmspec.core.diagnostics import WmsError

#: Limits of the reader: CPU seconds, bytes of address space, and additional bytes per byte of the file.
MAX_SECONDS, BASE_MEMORY, MEMORY_PER_BYTE = 30, 2**31, 20

#: Magic bytes of crates and of packages (zip), which may contain crates.
_BINARY = (b"PXR-USDC", b"PK\x03\x04")


def require_readable(path: Path) -> None:
    """Raise WmsError if a binary file cannot be read safely. Takes half a second the first time."""
    try:
        about = path.stat()
        with path.open("rb") as file:
            binary = file.read(8).startswith(_BINARY)
    except (OSError, ValueError):
        return  # USD reports it
    if binary and not _can_read(str(path), about.st_mtime_ns, about.st_size):
        raise WmsError("is damaged or needs too much memory", help="export it again")


@lru_cache(maxsize=256)
def _can_read(path: str, _changed: int, size: int) -> bool:
    command = [sys.executable, "-c", _READ, path, str(MAX_SECONDS), str(BASE_MEMORY + MEMORY_PER_BYTE * size)]
    quiet = subprocess.DEVNULL
    return subprocess.run(command, check=False, stdin=quiet, stdout=quiet, stderr=quiet).returncode == 0


#: Reads every value of a layer and of layers in the same package. Errors of USD are reported later.
_READ = """
import resource
import sys
from pxr import Sdf, Tf, Usd
path, seconds, memory = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

def read(layer):
    def values(path):
        spec = layer.GetObjectAtPath(path)
        for key in spec.ListInfoKeys() if spec else ():
            spec.GetInfo(key)
        for time in layer.ListTimeSamplesForPath(path):
            layer.QueryTimeSample(path, time)
    layer.Traverse("/", values)

root = Sdf.Layer.FindOrOpen(path)
read(root)
try:
    stage = Usd.Stage.Open(root, Usd.Stage.LoadNone)
    used = stage.GetUsedLayers()
except Tf.ErrorException:
    used = ()
for layer in used:
    if layer.identifier != root.identifier and layer.realPath.startswith(root.realPath):
        read(layer)
"""
