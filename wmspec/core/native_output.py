"""Suppresses output of native code: engines print from C++, past Python's streams."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def silence() -> Iterator[None]:
    """Drop everything that this process prints within the block."""
    sys.stdout.flush()
    sys.stderr.flush()
    copies = [(fd, os.dup(fd)) for fd in (1, 2)]
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        for fd, _ in copies:
            os.dup2(null, fd)
        yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for fd, copy in copies:
            os.dup2(copy, fd)
            os.close(copy)
        os.close(null)
