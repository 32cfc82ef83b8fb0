"""Scenes read part by part are those read from whole stages, to the bit; what has not changed is not read again."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given

from tests.examples import examples
from tests.language.specs import SPECS, random_spec, task_from, task_of
from tests.stage.same import difference
from wmspec.compile.design.design import Design
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.episode import build_document
from wmspec.compile.stage.layers import compose
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.runtime.caches import scene_cache
from wmspec.runtime.caches.cache_keys import form_key, look_key, physics_key
from wmspec.runtime.caches.scene_cache import SceneCache
from wmspec.sim.scene.model import Scene
from wmspec.sim.usd import read


def documents(spec: TaskSpec, instances: int, most: int | None = None) -> Iterator[Document]:
    """Some instances of a task from all over its design, and what they would be under some of their counterfactuals."""
    design = Design(spec)
    changes = [None, *[change for question in spec.questions for change in question.counterfactuals][:most]]
    for k in range(min(instances, len(design))):
        instance = design[k * len(design) // min(instances, len(design))]
        for change in changes:
            try:
                yield build_document(Evaluator(spec, instance.values, change, instance.key))
            except WmsError:
                continue  # it cannot be staged, which another test covers


def whole(document: Document) -> Scene | str:
    """The scene, or what is wrong."""
    try:
        return read(compose(document))
    except WmsError as error:
        return str(error)


def by_parts(cache: SceneCache, document: Document) -> Scene | str:
    """The same from parts."""
    try:
        return cache.scene(document)
    except WmsError as error:
        return str(error)


def agree(spec: TaskSpec, instances: int, most: int | None = None) -> None:
    """Check both readings, from the first document to the last and with what was known then back again."""
    cache, every = SceneCache(), list(documents(spec, instances, most))
    expected = [whole(document) for document in every]
    for k in (*range(len(every)), *reversed(range(len(every)))):
        scene = by_parts(cache, every[k])
        assert not difference(expected[k], scene)
        if isinstance(scene, Scene) and isinstance(one := expected[k], Scene):
            assert [key(one) for key in KEYS] == [key(scene) for key in KEYS]


#: Every fourth task, but one that walks and one of arms stand for two of them.
FEW = [path for path in SPECS[::4] if path.stem != "arms_lift" and path.parent.name != "transitivity"]
KEYS = (physics_key, look_key, form_key)


@pytest.mark.parametrize("path", FEW, ids=lambda path: path.stem)
def test_every_task_is_read_alike(path: Path) -> None:
    agree(task_of(path), 2, most=1)


@pytest.mark.slow
@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_many_instances_of_every_task_are_read_alike(path: Path) -> None:
    agree(task_of(path), 12)


@examples(3, 6, suppress_health_check=list(HealthCheck))
@given(random_spec())
def test_random_tasks_are_read_alike(spec: TaskSpec) -> None:
    agree(spec, 2, most=1)


def test_only_what_changed_is_read_again(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = task_from(
        """
        use tabletop
        task t : custom {
          factor tone in [red, blue]
          object ball { shape: sphere  size: 8 cm  color: tone  on: table at (0, 0) }
          object crate { shape: cube  size: 8 cm  on: table at (20 cm, 0) }
          observe front at [0 s]
        }
        """
    )
    small: list[Scene] = []
    monkeypatch.setattr(scene_cache, "read", lambda stage: small.append(read(stage)) or small[-1])
    cache, (red, blue) = SceneCache(), list(documents(spec, 2))
    cache.scene(red)
    cache.scene(blue)
    cache.scene(red)
    assert len(small) == 2
    assert "crate" in {body.name for body in small[0].bodies}
    assert [body.name for body in small[1].bodies] == ["ball"]


def test_little_is_remembered() -> None:
    cache = SceneCache(remembered=12)
    (spec,) = (task_of(path) for path in SPECS if path.stem == "collide")
    for document in documents(spec, 3, most=1):
        assert not difference(read(compose(document)), cache.scene(document))
        assert len(cache._known) <= 12
