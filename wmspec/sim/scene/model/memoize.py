"""What is worked out of a body once: bodies never change, and most of a scene were in the scene before."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

from wmspec.sim.scene.model import Body

T = TypeVar("T")


def kept(body: Body, make: Callable[[Body], T]) -> T:
    """What `make` makes of the body, made when it is first asked for and kept with it."""
    name = f"{make.__module__}.{make.__qualname__}"
    if name not in body.__dict__:
        body.__dict__[name] = make(body)
    return cast(T, body.__dict__[name])
