"""What the syntax tree and the IR are made of: dataclasses that are quick to define.

`@dataclass(frozen=True)` writes and compiles six methods of each class, and there are so many kinds of nodes that this
was a seventh of what `wmspec check` takes. Here it is one, and the others are the same for all. That nothing changes a
node is left to the type checker.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, dataclass_transform


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
class Node:
    """Base of frozen dataclasses, compared by value; they need no decorator.

    What pydantic reads as one has no more fields than it says, and numbers in it are finite.
    """

    __pydantic_config__: ClassVar[Mapping[str, str | bool]] = {"extra": "forbid", "allow_inf_nan": False}

    def __init_subclass__(cls, kw_only: bool = False) -> None:
        dataclass(eq=False, repr=False, kw_only=kw_only)(cls)

    def __eq__(self, other: object) -> bool:
        return self.__dict__ == other.__dict__ if other.__class__ is self.__class__ else NotImplemented

    def __hash__(self) -> int:
        return hash((self.__class__, *self.__dict__.values()))

    def __repr__(self) -> str:
        return f"{self.__class__.__qualname__}({', '.join(f'{k}={v!r}' for k, v in self.__dict__.items())})"
