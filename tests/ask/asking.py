"""Asking small specs, written as text, in one engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from tests.engines import ENGINES, installed
from tests.examples import slow_except
from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.questions.ask import ask
from wmspec.runtime.questions.model import QuestionRow, Rejected
from wmspec.runtime.questions.runs import EnginePair, Run, execute

SCENE = """
use tabletop
task t : custom {{
  {body}
}}
"""


def spec_of(body: str) -> TaskSpec:
    """A task with this body, on a table. Its scenes are small, so its questions may be illegible."""
    spec = task_from(SCENE.format(body=body))
    return replace(spec, questions=tuple(replace(question, legible=False) for question in spec.questions))


def quick_matrix(cases: Sequence[tuple[str, ...]], quickest: str, every: int) -> list[Any]:
    """The cases, each with an engine: all in the quickest, and some in the others; the rest where slow tests run."""
    quick = [(*case, engine) for engine in ENGINES for case in (cases if engine == quickest else cases[::every])]
    return slow_except(quick, [(*case, engine) for engine in ENGINES for case in cases])


@cache
def pair(engine: str = "pybullet", side: int = 128) -> EnginePair:
    """One for all tests: what it remembers is found by what it shows."""
    installed(engine)
    return EnginePair(TraceCache(engine), RenderCache(engine, side, side))


def ask_all(body: str, index: int = 0, engine: str = "pybullet") -> list[QuestionRow | Rejected]:
    """The questions of an instance of a task with this body, on a table."""
    return ask(Design(spec_of(body)), index, pair(engine))


def one(body: str, index: int = 0, engine: str = "pybullet") -> QuestionRow:
    """The only question, which is asked."""
    (found,) = ask_all(body, index, engine)
    assert isinstance(found, QuestionRow), found
    return found


def refused(body: str, index: int = 0, engine: str = "pybullet") -> str:
    """Why the only question is not asked."""
    (found,) = ask_all(body, index, engine)
    assert isinstance(found, Rejected), found.text
    return f"{found.reason}: {found.detail}"


def run(body: str, index: int = 0) -> Run:
    """The executed instance."""
    design = Design(spec_of(body))
    return execute(design, design[index], None, pair())
