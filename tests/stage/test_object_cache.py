"""Cached objects are bit for bit those that would be made again; what is the same is made once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given

from tests.examples import examples
from tests.language.specs import SPECS, random_spec, task_from, task_of
from tests.stage.test_parts import FEW
from wmspec.compile.design.design import Design
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage import object_cache
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.episode import build_document
from wmspec.compile.stage.object_cache import ObjectCache
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir.ir import TaskSpec


def worlds(spec: TaskSpec, groups: int, instances: int, most: int | None = None) -> Iterator[Evaluator]:
    """Neighbours in some places of a task, and each under some of its counterfactuals."""
    design = Design(spec)
    changes = [None, *[change for question in spec.questions for change in question.counterfactuals][:most]]
    for group in range(groups):
        first = group * len(design) // groups
        for index in range(first, min(first + instances, len(design))):
            instance = design[index]
            yield from (Evaluator(spec, instance.values, change, instance.key) for change in changes)


def made(values: Evaluator, objects: ObjectCache | None) -> tuple[list[tuple[str, bytes]], Document] | str:
    """What all prims say, in order, with the sources of that; or what is wrong."""
    rebuilt = Evaluator(values.spec, values.own, values.change, values.key)
    try:
        document = build_document(rebuilt, objects)
    except WmsError as error:
        return str(error)
    return [(path, prim.content) for path, prim in document.prims.items()], document


def agree(spec: TaskSpec, groups: int, instances: int, most: int | None = None) -> None:
    """Check both, from the first world to the last and with what was known then back again."""
    objects, every = ObjectCache(), list(worlds(spec, groups, instances, most))
    expected = [made(values, None) for values in every]
    for k in (*range(len(every)), *reversed(range(len(every)))):
        assert made(every[k], objects) == expected[k]


@pytest.mark.parametrize("path", FEW, ids=lambda path: path.stem)
def test_objects_of_every_task_are_alike(path: Path) -> None:
    agree(task_of(path), 2, 2, most=1)


@pytest.mark.slow
@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_objects_of_many_instances_are_alike(path: Path) -> None:
    agree(task_of(path), 3, 6)


@examples(4, 12, suppress_health_check=list(HealthCheck))
@given(random_spec())
def test_objects_of_random_tasks_are_alike(spec: TaskSpec) -> None:
    agree(spec, 2, 2, most=1)


ROOM = """
use tabletop
task t : custom {
  factor tone in [red, blue]
  factor far  in [0 cm, 10 cm]
  object ball { shape: sphere  size: 8 cm  color: tone  on: table at (0, 0) }
  object slab { shape: box  size: (20 cm, 20 cm, 2 cm)  on: table at (30 cm, far) }
  object cup  { shape: cylinder  size: 6 cm  on: slab at (0, 0) }
  objects pebbles[3] { shape: sphere  size: 2 cm  on: table  scatter: (20 cm, 20 cm)  gap: 5 mm }
  observe front at [0 s]
}
"""


def test_only_changes_are_generated_again(monkeypatch: pytest.MonkeyPatch) -> None:
    spec, names = task_from(ROOM), []
    plain = object_cache.add_object  # type: ignore[attr-defined]

    def noted(document: Document, name: str, *rest: object) -> None:
        names.append(name)
        plain(document, name, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(object_cache, "add_object", noted)
    objects, levels = ObjectCache(), {"tone": "red", "far": 0.0}

    def again(key: int = 0, **changed: object) -> set[str]:
        names.clear()
        build_document(Evaluator(spec, levels | changed, None, ("seed", key)), objects)
        assert len(names) == len(set(names))
        return set(names)

    pebbles = {"pebbles_0", "pebbles_1", "pebbles_2"}
    assert again() >= {"ball", "slab", "cup", "table"} | pebbles
    assert again() == set()
    assert again(tone="blue") == {"ball"}
    assert again(far=0.1) == {"slab", "cup"}
    assert again(far=0.1, tone="blue") == set()
    assert again(key=1) == pebbles


def test_little_is_remembered() -> None:
    objects, spec = ObjectCache(remembered=3, specs=2), task_from(ROOM)
    for values in worlds(spec, 2, 2):
        assert made(values, objects) == made(values, None)
        assert len(objects._made) <= 3
    for _ in range(3):  # an `id` may come again, so what is remembered keeps its spec
        other = task_from(ROOM)
        for values in worlds(other, 1, 1):
            assert made(values, objects) == made(values, None)
        assert all(key[0] == id(kept) for key, (kept, _) in objects._made._values.items())
