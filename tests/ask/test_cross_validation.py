"""Several engines answer a question: one row stands for all of them, and says how far apart they were."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from tests.ask.asking import spec_of
from tests.engines import installed
from wmspec.compile.design.design import Design
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.engines import registry
from wmspec.runtime.questions.consensus import Consensus
from wmspec.runtime.questions.cross_validation import CrossValidation
from wmspec.runtime.questions.model import QuestionRow, Rejected
from wmspec.runtime.questions.runs import EnginePair
from wmspec.sim.scene.backend import Info
from wmspec.sim.scene.model import Scene, Trace

GLIDE = """
  object ball  { shape: sphere  size: 8 cm  color: red  on: table at (0, 0) }
  object block { shape: cube  size: 8 cm  color: blue  on: table at (-35 cm, 0) }
  action go = glide(ball, direction: away, speed: 10 cm/s) for 1 s
  observe front at [0 s, 1 s]
  question "How far does the ball go?" { answer displacement(ball)  within 1 cm }
  question "Where is it?" { answer relation(ball, block)  options [right_of, left_of, behind, in_front_of] }
"""


@dataclass(frozen=True)
class Drifting:
    """An engine that executes as PyBullet does, while everything that can move drifts away at `speed` (m/s)."""

    name: str
    speed: float

    @property
    def info(self) -> Info:
        return replace(registry.info("pybullet"), name=self.name, draws=False)

    def execute(self, scene: Scene) -> Trace:
        trace = installed("pybullet").execute(scene)
        can = [body.motion != "static" for body in scene.bodies]
        drift = np.outer(trace.time, can)[..., None] * (0.0, self.speed, 0.0)
        return replace(trace, engine=self.name, position=trace.position + drift)

    def renderer(self, *_: Any) -> Any:
        raise AssertionError("another engine draws")

    def native(self, scene: Scene) -> dict[str, str]:
        return {}


@pytest.fixture(autouse=True)
def drifting_engines() -> Iterator[None]:
    installed("pybullet")
    for backend in (Drifting("near", 0.001), Drifting("far", 0.2), Drifting("farther", 0.4)):
        registry.register(backend)
    yield
    registry._registered.clear()
    for known in (registry.info, registry.backend):
        known.cache_clear()


def validation(engines: tuple[str, ...], required: Consensus, body: str = GLIDE) -> CrossValidation:
    renders = RenderCache("pybullet", 96, 96)
    pairs = {engine: EnginePair(TraceCache(engine), renders) for engine in engines}
    return CrossValidation(Design(spec_of(body)), 0, pairs, required)


def row(engines: tuple[str, ...], required: Consensus, q: int = 0) -> QuestionRow | Rejected:
    questions = validation(engines, required).questions()
    assert [one.question for one in questions] == [0, 1]
    return questions[q]


@pytest.mark.parametrize(
    ("engines", "required", "executed_in"),
    [
        (("pybullet", "near"), "all", "pybullet"),
        (("near", "pybullet"), "all", "near"),
        (("pybullet", "near", "far"), "all", None),
        (("far", "pybullet", "near"), "majority", "pybullet"),
        (("farther", "far", "near"), "majority", None),
        (("far", "pybullet"), "none", "far"),
    ],
)
def test_the_row_is_that_of_the_first_engine_whose_answer_is_kept(
    engines: tuple[str, ...], required: Consensus, executed_in: str | None
) -> None:
    kept = row(engines, required)
    if executed_in is None:
        assert isinstance(kept, Rejected)
        assert (kept.reason, kept.engine) == ("disagreement", engines[0])
        assert all(engine in kept.detail for engine in engines)
    else:
        assert isinstance(kept, QuestionRow)
        assert (kept.engine, kept.renderer) == (executed_in, "pybullet")
        assert [vote.engine for vote in kept.agreement] == sorted(engines)


def test_row_has_the_distance_between_engines() -> None:
    kept = row(("pybullet", "near", "far"), "none")
    assert isinstance(kept, QuestionRow)
    apart = {vote.engine: vote.apart for vote in kept.agreement}
    assert apart["pybullet"] == 0.0
    assert apart["near"] == pytest.approx(0.001, rel=0.01), "1 mm/s for 1 s"
    assert apart["far"] == pytest.approx(0.2, rel=0.01)
    assert {vote.engine: vote.value for vote in kept.agreement}["far"] != kept.value


def test_one_row_is_the_row_of_the_reference_among_rows_of_engines() -> None:
    engines = ("pybullet", "near")
    one, each = validation(engines, "all").questions(), validation(engines, "all").rows()
    assert [(r.question, r.engine) for r in each] == [(q, engine) for q in (0, 1) for engine in engines]
    for mine, its in zip(one, (r for r in each if r.engine == "pybullet"), strict=True):
        assert isinstance(mine, QuestionRow)
        assert isinstance(its, QuestionRow)
        for name in ("text", "options", "answer", "value", "measured", "agreement"):
            a, b = getattr(mine, name), getattr(its, name)
            assert a == b, name
        assert all(np.array_equal(a.rgb, b.rgb) for a, b in zip(mine.context, its.context, strict=True))


def test_an_engine_that_cannot_execute_it_rejects_it_by_name() -> None:
    class Failing(Drifting):
        def execute(self, scene: Scene) -> Trace:
            raise WmsError("it has no floor")

    registry.register(Failing("failing", 0.0))
    first, second = row(("pybullet", "failing"), "all"), row(("failing", "pybullet"), "none")
    assert isinstance(first, Rejected)
    assert "failing rejects it: invalid: it has no floor" in first.detail
    assert isinstance(second, QuestionRow)
    assert {vote.engine: vote.apart for vote in second.agreement} == {"pybullet": 0.0, "failing": None}


def test_instances_rejected_by_the_reference_run_in_no_other_engine() -> None:
    renders = RenderCache("pybullet", 96, 96)
    pairs = {engine: EnginePair(TraceCache(engine), renders) for engine in ("pybullet", "near")}
    impossible = GLIDE.replace("within 1 cm", "within 1 cm  ensure displacement(ball) > 1 m")
    design = Design(spec_of(impossible))
    answers = CrossValidation(design, 0, pairs, "all").questions()
    assert [getattr(answer, "reason", "") for answer in answers] == ["ensure", ""]
    assert pairs["near"].traces.requests == 1, "for the other question"
