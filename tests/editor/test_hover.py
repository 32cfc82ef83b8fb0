"""What the editor shows for the words of hidden things, what-ifs and sets of actions."""

from __future__ import annotations

from pathlib import Path

import pytest

from wmspec.editor.document import Document
from wmspec.editor.hover import hover

_WORDS = """use room

task t : custom {
  factor   n in [1, 2]
  nuisance pace[2] in 75 cm/s .. 85 cm/s
  object belt { shape: box  size: 9 cm  at: (0, 0, 30 cm)  fixed: true  surface_velocity: (1 m/s, 0, 0) }
  objects balls[2] { shape: sphere  size: 9 cm  on: floor at (-30 cm, 15 cm * index) }
  actions roll[2] = launch(balls[index], direction: right, speed: pace[index]) at 0.1 s when n == 1
  action gone = pass_through(balls[0], balls[1]) for 0.4 s
  observe front at [0 s, 1 s]
  question a "A?" { answer contact(balls[0], floor) without belt  may hide balls }
  question b "B?" { answer contact(balls[0], floor) under n: 2  seen balls at [0 s] }
  question c "C?" { options [belt, floor]  answer cause of contact(balls[0], belt) among [belt, floor]  seen none }
  question d "D?" { answer possible }
}
"""


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        ("surface_velocity", "velocity of its surface"),
        ("pace[2]", "list of speeds"),
        ("actions", "actions name[count]"),
        ("when", "when kind"),
        ("pass_through", "lets the object pass through another one"),
        ("without", "in the episode with one change"),
        ("under", "in the episode with one change"),
        ("may", "may be invisible in all pictures"),
        ("hide balls", "may be invisible in all pictures"),
        ("seen balls", "must be visible at these times"),
        ("none", "no object must be visible"),
        ("cause", "without which the condition does not hold"),
        ("among", "without which the condition does not hold"),
        ("possible", "a violation of them"),
    ],
)
def test_words_of_hidden_things_and_what_ifs_have_documentation(word: str, expected: str) -> None:
    shown = hover(Document(Path("test.wms"), _WORDS), _WORDS.index(word) + 1)
    assert shown is not None
    assert expected in shown.markdown
