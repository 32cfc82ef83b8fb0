"""What an instance would be under other levels is its sibling, to the letter; so its scene is shared."""

from __future__ import annotations

import pytest

import wmspec
from wmspec.compile.stage.episode import build_document
from wmspec.core.resources import resource
from wmspec.runtime.caches.scene_cache import SceneCache
from wmspec.runtime.questions.runs import values_of

TASKS = ("perception/space/positioning", "prediction/mechanistic/collide", "prediction/mechanistic/arm_push")


@pytest.mark.parametrize("path", TASKS)
def test_an_option_is_a_sibling(path: str) -> None:
    task = wmspec.load_all(resource(f"specs/{path}.wms"))[0]
    scenes, shared = SceneCache(), 0
    one = task.design[5]
    mine = scenes.of(values_of(task.design, one))
    for question in task.spec.questions:
        for change in question.alternatives(one.values):
            values = values_of(task.design, one, change)
            assert change.change == "levels"
            index = task.design.index(one.factors | change.levels, one.block)
            assert index is not None
            sibling = values_of(task.design, task.design[index])
            assert build_document(values) == build_document(sibling)
            assert scenes.of(values) is scenes.of(sibling)
            assert scenes.of(values) is not mine
            shared += 1
    assert shared
