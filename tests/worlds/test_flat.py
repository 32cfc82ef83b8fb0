"""What the flat's `marks` name is seen in one direction only, wherever the walker of the tasks `walk` stands."""

from __future__ import annotations

import math
from itertools import product

import pytest

from tools import worlds
from wmspec.runtime.engines.registry import default

#: The middle of each room (m), and the objects that `marks` names: to the east, north, west and south.
ROOMS = {
    "living room": (-2.75, -2.25, ["living_cupboard", "living_clock", "living_sofa", "living_television"]),
    "bedroom": (-2.75, 2.25, ["bedroom_chair", "bedroom_teddy", "bedroom_bed", "bedroom_clock"]),
    "kitchen": (2.75, -2.25, ["kitchen_dining_table", "kitchen_television", "kitchen_clock", "kitchen_window"]),
    "study": (2.75, 2.25, ["cartons", "study_monitor", "study_teddy", "study_clock"]),
}
#: How far the tasks move the walker from the middle (m) and turn it (deg), to either side.
ACROSS, ALONG, ASKEW = 0.35, 0.15, 8
#: The heights of its eyes, and of the points 2 m ahead at which they look (m).
EYES = [(0.6, 0.9), (1.5, 1.32)]
TASK = """
use apartment(furnished: "{room}")
task looks : custom {{
  factor only in [1, 2]
{cameras}
  observe look_0 at [0 s]
}}
"""
CAMERA = "  camera look_{0} {{ at: ({1} m, {2} m, {3} m)  look_at: ({4} m, {5} m, {6} m)  fov: 75 deg }}"


@pytest.mark.broad
@pytest.mark.engine
@pytest.mark.parametrize("room", ROOMS)
def test_a_mark_is_seen_in_its_direction_only(room: str) -> None:
    middle_x, middle_y, marks = ROOMS[room]
    cameras: list[str] = []
    shown: list[int] = []
    for mark, across, along, askew, (eye, target) in product(
        range(4), (-ACROSS, ACROSS), (-ALONG, ALONG), (-ASKEW, ASKEW), EYES
    ):
        x, y, heading = middle_x + across, middle_y + along, math.radians(90 * mark + askew)
        ahead = x + 2 * math.cos(heading), y + 2 * math.sin(heading)
        cameras.append(CAMERA.format(len(cameras), x, y, eye, *ahead, target))
        shown.append(mark)
    flat = worlds.scene(TASK.format(room=room, cameras="\n".join(cameras)))
    drawn = worlds.frames(flat, default(), 64, [f"look_{n}" for n in range(len(cameras))])
    for mark, frame in zip(shown, drawn, strict=True):
        visible = {flat.bodies[i].name for i in set(frame.ids.flat) if i >= 0}
        assert [name for name in marks if name in visible] == [marks[mark]]
