"""What goes to a worker together: every instance once, what is asked as a whole undivided, groups side by side."""

import random

import pytest

import wmspec
from wmspec.core.resources import resource
from wmspec.dataset.build.batching import MAX_BATCH, batches
from wmspec.runtime.questions.closed_sets import has_closed_set

TASKS = {
    "positioning_tabletop": "perception/space/positioning.wms",  # closed sets in groups that cross more
    "direction_room": "perception/motion/direction.wms",  # nuisances that physics reads
    "color_room": "perception/vision/color.wms",  # looks alone
    "collide": "prediction/mechanistic/collide.wms",  # closed sets that are whole groups
}


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("part", [1.0, 0.3])
def test_units(name: str, part: float) -> None:
    task = wmspec.load(resource("specs") / TASKS[name], task=name)
    chance = random.Random(name)
    indices = [index for index in range(len(task)) if chance.random() < part]
    made = list(batches(task.spec, 0, indices))
    assert sorted(index for unit in made for piece in unit for index in piece) == indices
    assert all(len(unit) == 1 or sum(map(len, unit)) <= MAX_BATCH for unit in made)
    pieces = [piece for unit in made for piece in unit]
    blocks = [{task.design.blocks.locate(index)[0] for index in piece} for piece in pieces]
    assert all(len(of) == 1 for of in blocks)
    if has_closed_set(task.spec):  # each group is asked once
        assert len(pieces) == len({block for (block,) in blocks})


def test_group_with_physical_draws_goes_to_one_worker() -> None:
    task = wmspec.load(resource("specs") / TASKS["direction_room"], task="direction_room")
    for unit in batches(task.spec, 0, range(400)):
        assert len({task.design.blocks.locate(index)[0] for piece in unit for index in piece}) == 1
    assert len(list(batches(task.spec, 0, range(400)))) <= 400 // 8
