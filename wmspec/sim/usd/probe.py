"""Reads untrusted USD files first in a separate process with bounds on memory and time.

USD trusts the lengths in binary files and recurses in nested text: a damaged or hostile file can crash the reader, fill
its memory or keep it busy for hours. The process is started once, and again after such a file.
"""

from __future__ import annotations

import atexit
import os
import select
import subprocess
import sys
from functools import lru_cache
from pathlib import Path
from threading import Lock
from time import monotonic
from typing import IO, Literal

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import open_file

#: Time limit (s) of a file, and per byte of it; bytes of address space, and additional bytes per byte of the file.
MAX_SECONDS, SECONDS_PER_BYTE, BASE_MEMORY, MEMORY_PER_BYTE = 30.0, 1e-6, 2**31, 20
#: Time to start the process (s).
START_SECONDS = 60.0

Request = Literal["layer", "stage"]


def require_readable(path: Path, request: Request = "layer", shown: str = "") -> None:
    """Raise WmsError if a layer, or the stage of a file with all its layers, cannot be read within the bounds.

    `path` is a regular file, and the message calls it `shown`. Takes half a second the first time, then about
    the time of reading it.
    """
    about = path.stat()
    if not _can_read(str(path), about.st_mtime_ns, about.st_size, request):
        reason = "is damaged, or needs too much time or memory"
        raise WmsError(reason, FilePlace(shown) if shown else None, "export it again, or make it simpler")


@lru_cache(maxsize=4096)
def _can_read(path: str, _changed: int, size: int, request: Request) -> bool:
    with _lock:
        return _process().can_read(path, size, request)


_lock = Lock()
_processes: dict[int, _Process] = {}


def _process() -> _Process:
    """Return the reading process of this process; a fork does not share that of its parent."""
    known = _processes.get(os.getpid())
    if known is None or not known.alive:
        _processes.clear()
        atexit.register(_stop)
        known = _processes[os.getpid()] = _Process()
    return known


def _stop() -> None:
    if known := _processes.get(os.getpid()):
        known.stop()


class _Process:
    """The reading process: answers one line for each line that it receives."""

    def __init__(self) -> None:
        quiet = subprocess.DEVNULL
        command = [sys.executable, "-c", _READ]
        self._child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=quiet, bufsize=0)
        if self._answer(START_SECONDS) != b"ready":
            self.stop()

    @property
    def alive(self) -> bool:
        """Whether it can receive another request."""
        return self._child.poll() is None

    def stop(self) -> None:
        """End it."""
        self._child.kill()
        self._child.wait()
        for stream in (self._child.stdin, self._child.stdout):
            _stream(stream).close()

    def can_read(self, path: str, size: int, request: Request) -> bool:
        """Whether it reads a file within the bounds; otherwise it is stopped."""
        memory = BASE_MEMORY + MEMORY_PER_BYTE * size
        try:
            _stream(self._child.stdin).write(f"{request} {memory} {os.fsencode(path).hex()}\n".encode())
        except OSError:
            return False
        answer = self._answer(MAX_SECONDS + SECONDS_PER_BYTE * size)
        if not answer:
            self.stop()
        return answer == b"read" or (answer == b"failed" and (request == "stage" or _is_text(path)))

    def _answer(self, seconds: float) -> bytes:
        """Return the next line, or b"" if there is none in time or the process ended."""
        stream, line, end = _stream(self._child.stdout), b"", monotonic() + seconds
        while not line.endswith(b"\n"):
            if not select.select([stream], [], [], max(0.0, end - monotonic()))[0]:
                return b""
            part = stream.read(64)
            if not part:
                return b""
            line += part
        return line.strip()


def _is_text(path: str) -> bool:
    """Whether a layer is text, whose errors USD reports with their line."""
    with open_file(Path(path)) as file:
        return file.read(5) == b"#usda"


def _stream(stream: IO[bytes] | None) -> IO[bytes]:
    assert stream is not None
    return stream


#: Reads every value of a layer and of layers in its package, or composes a stage. USD reports errors later.
_READ = """
import os
import resource
import sys
from pxr import Sdf, Tf, Usd
out = os.dup(1)
os.dup2(2, 1)
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

def read(layer):
    def values(path):
        spec = layer.GetObjectAtPath(path)
        for key in spec.ListInfoKeys() if spec else ():
            spec.GetInfo(key)
        for time in layer.ListTimeSamplesForPath(path):
            layer.QueryTimeSample(path, time)
    layer.Traverse("/", values)

def read_layer(path):
    root = Sdf.Layer.FindOrOpen(path)
    read(root)
    if not path.endswith(".usdz"):
        return
    stage = Usd.Stage.Open(root, Usd.Stage.LoadNone)
    for layer in stage.GetUsedLayers():
        if layer.identifier != root.identifier and layer.realPath.startswith(root.realPath):
            read(layer)

def read_stage(path):
    stage = Usd.Stage.Open(path)
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        prim.GetAuthoredPropertyNames()

os.write(out, b"ready\\n")
for line in sys.stdin.buffer:
    request, memory, path = line.split()
    limit = int(memory)
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))
    try:
        {b"layer": read_layer, b"stage": read_stage}[request](os.fsdecode(bytes.fromhex(path.decode())))
    except MemoryError:
        os._exit(1)
    except Exception:
        os.write(out, b"failed\\n")
    else:
        os.write(out, b"read\\n")
"""
