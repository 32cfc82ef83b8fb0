"""Content hashes of values: equal values have equal hashes in every process."""

from __future__ import annotations

import hashlib
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from wmspec.core.canonical import dumps


def digest(*values: Any) -> bytes:
    """Return the hash (16 bytes) of dataclasses, sequences, arrays, numbers, strings and None, in this order."""
    return hashlib.blake2b(dumps(_to_plain(values)), digest_size=16).digest()


def _to_plain(value: Any) -> Any:
    """Return a value as tuples, strings, bytes and numbers."""
    if value is None or type(value) in {float, int, str, bool, bytes}:
        return value
    if isinstance(value, tuple | list):
        return tuple([_to_plain(part) for part in value])
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, np.generic):
        return value.dtype.str, value.tobytes()
    if is_dataclass(value):
        return (type(value).__name__, *[_to_plain(getattr(value, field.name)) for field in fields(value)])
    raise TypeError(f"{type(value).__name__} has no content hash")
