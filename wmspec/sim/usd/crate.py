"""Binary files of USD, read once by a process of its own before this one opens them.

USD trusts what such a file says of its own lengths: a damaged one can end the process that reads it, or fill its
memory. Texts, which it parses, cannot.
"""

from __future__ import annotations

import subprocess
import sys
from functools import lru_cache
from pathlib import Path

from wmspec.core.diagnostics import WmsError

#: Processor seconds that reading all of a file may take, and bytes of address space: so many, and per byte of the file.
SECONDS, MEMORY, PER_BYTE = 30, 2**31, 20

#: How binary files begin: a crate, and a package (zip), which may hold crates.
_BINARY = (b"PXR-USDC", b"PK\x03\x04")


def trusted(path: Path) -> None:
    """Raise WmsError if a binary file cannot be read without harm. Takes half a second the first time."""
    try:
        about = path.stat()
        with path.open("rb") as file:
            binary = file.read(8).startswith(_BINARY)
    except (OSError, ValueError):
        return  # USD tells it
    if binary and not _survives(str(path), about.st_mtime_ns, about.st_size):
        raise WmsError("is damaged, or would fill the memory", help="export it again")


@lru_cache(maxsize=256)
def _survives(path: str, _changed: int, size: int) -> bool:
    command = [sys.executable, "-c", _READ, path, str(SECONDS), str(MEMORY + PER_BYTE * size)]
    quiet = subprocess.DEVNULL
    return subprocess.run(command, check=False, stdin=quiet, stdout=quiet, stderr=quiet).returncode == 0


#: Reads every value of a layer, and of those in the same package. What USD complains of is told later.
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
