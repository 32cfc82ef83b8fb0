"""Values computed once per body: bodies are immutable, and consecutive scenes share most of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

from wmspec.sim.scene.model import Body

T = TypeVar("T")


def cached_on(body: Body, make: Callable[[Body], T]) -> T:
    """Return `make(body)`, computed on first use and stored with the body."""
    name = f"{make.__module__}.{make.__qualname__}"
    if name not in body.__dict__:
        body.__dict__[name] = make(body)
    return cast(T, body.__dict__[name])
