"""Plain values as bytes."""

from __future__ import annotations

import marshal
from typing import Any

#: The last version of marshal's format that does not depend on which objects are the same, or on interned strings.
_FORMAT = 2


def dumped(value: Any) -> bytes:
    """Numbers, strings, bytes, None, and tuples, lists and dictionaries of them: the same bytes for the same.

    Raises ValueError for anything else.
    """
    return marshal.dumps(value, _FORMAT)


def loaded(content: bytes) -> Any:
    """What was dumped, in this process."""
    return marshal.loads(content)  # noqa: S302  nobody else wrote it
