"""Cars and walkers are where they were planned to be, in every engine; what one sees is seen in all of them."""

from __future__ import annotations

import numpy as np
import pytest

import wmspec
from tests.engines import ENGINES, installed
from tests.language.test_robots import ROOM, TOWN, planned

CAR = TOWN.format(
    acts="action one = taxi.forward(5 m) for 1.5 s\n  action two = taxi.turn(right) for 4 s after one",
    at=(2, -20),
    yaw=90,
    wide=8,
    says="",
    more="light sun { shadows: false }\n  object barn { shape: cube  size: 8 m  on: ground at (12 m, 12 m) }",
).replace("horizon 60 s", "horizon 5.5 s")
WALK = ROOM.format(
    acts="action one = someone.move(3 m) for 2 s\n  action two = someone.turn(left, angle: 70 deg) for 1 s after one",
    at=(0, 0),
    yaw=30,
    more="object wall { shape: box  size: (10 cm, 9 m, 2 m)  color: oak  on: floor at (1.5 m, 0)  fixed: true }",
).replace("horizon 60 s", "horizon 3 s")


@pytest.mark.engine
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("text", "robot"), [(CAR, "taxi"), (WALK, "someone")], ids=["car", "walker"])
def test_they_go_as_planned(engine: str, text: str, robot: str) -> None:
    installed(engine)
    task = wmspec.load(text=text)
    run, plan = task[0].run(engine), planned(task.spec)
    for name in ("one", "two"):
        travel, start = plan[name], task.spec.thing(name).properties["start"].value
        moments = np.array(travel.times) + (0.0 if name == "one" else plan["one"].times[-1])
        where = np.array([np.interp(moments, run.time, run[robot].position[:, i]) for i in range(3)]).T
        assert start is not None
        assert np.abs(where - np.array(travel.points)).max() < 1e-3


@pytest.mark.pixels
@pytest.mark.parametrize("engine", ENGINES)
def test_without_shadows_what_lies_behind_a_thing_is_lit(engine: str) -> None:
    installed(engine)
    text = """
        task t : custom {
          factor size in [20, 30] cm
          light sun { direction: (1, 0, -1)  %s }
          object floor { shape: box  size: (3 m, 3 m, 10 cm)  color: white  at: (0, 0, -5 cm)  fixed: true }
          object block { shape: cube  size: size  color: red  on: floor at (0, 0) }
          camera above { at: (0, -1 cm, 1.4 m)  look_at: (0, 0, 0) }
          observe above at [0 s]
        }
    """
    lit, dark = (wmspec.load(text=text % says)[0].run(engine) for says in ("shadows: false", ""))
    a, b = (run.frame("above", 0.0).astype(int) for run in (lit, dark))
    floor = (lit.ids("above", 0.0) == lit.ids("above", 0.0)[5, 5]) & (dark.ids("above", 0.0) >= 0)
    darker = [(np.median(picture[floor].sum(axis=1)) - picture[floor].sum(axis=1) > 60).mean() for picture in (a, b)]
    assert darker[0] < 0.01, "the floor is lit evenly but for a line of pixels around the block"
    assert darker[1] > 0.025, "and else it is not"
