"""The world of a task and that of its library are one: the task's properties replace the library's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from wmspec.lang.parse import syntax as s


def merged_worlds(statements: Sequence[s.Statement], task: s.Task | None) -> list[s.Statement]:
    """Return the statements with the world of a library merged into the task's own, such as `world { gravity: 0 }`.

    Worlds of several libraries, and several of the task, are left as they are: these are mistakes.
    """
    worlds = [each for each in statements if isinstance(each, s.Block) and each.kind == "world"]
    own = [world for world in worlds if task is not None and world.span.source is task.span.source]
    others = [world for world in worlds if world not in own]
    if len(own) != 1 or len(others) != 1:
        return list(statements)
    written = {each.name.id for each in own[0].properties}
    inherited = (each for each in others[0].properties if each.name.id not in written)
    merged = replace(own[0], properties=(*own[0].properties, *inherited))
    return [merged if each is own[0] else each for each in statements if each is not others[0]]
