"""Engines that fail, each in its own way, and a sound one: all are the toy of tests/recipes but for that."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from typing import Any

import wmspec_toy  # type: ignore[import-not-found]  # found on the path of the shell that the test starts


class Engine:
    """The toy engine, with what it does before it executes."""

    def __init__(self, name: str, before: Any) -> None:
        self.info = replace(wmspec_toy.info, name=name, module="wmspec_broken", distribution="wmspec-broken")
        self.renderer, self.native, self._before = wmspec_toy.renderer, wmspec_toy.native, before

    def execute(self, scene: Any) -> Any:
        self._before(scene)
        return replace(wmspec_toy.execute(scene), engine=self.info.name)


def _nothing(_: object) -> None:
    pass


def _mistaken(_: object) -> None:
    raise AttributeError("there is no such thing as " + "a step " * 100)


def _lacking(_: object) -> None:
    from wmspec.sim.scene import nowhere  # type: ignore[attr-defined]  # noqa: F401


def _out_of_library(_: object) -> None:
    raise ImportError("libfoo.so.7: cannot open shared object file: No such file or directory", name="foo")


def _dying(_: object) -> None:
    sys.stdout.flush()
    os._exit(7)


sound = Engine("sound", _nothing)
mistaken, lacking = Engine("mistaken", _mistaken), Engine("lacking", _lacking)
unlinked, dying = Engine("unlinked", _out_of_library), Engine("dying", _dying)
