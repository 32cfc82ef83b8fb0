"""What pictures show, against where bodies are: silhouettes, shares, what hides what, what stands out."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tests.ask.asking import one, pair, refused, run
from wmspec.runtime.questions import visibility
from wmspec.runtime.questions.observed import Observed

LOOK = ("front", 0.0)
OBJECT = "object {name} {{ shape: {shape}  size: 10 cm  color: {color}  on: table at ({at}) }}"
SHAPES = ("cube", "sphere", "cylinder", "cone", "capsule", "wedge")


def seen(*objects: str) -> Observed:
    return run("\n".join([*objects, "observe front at [0 s]"])).observed([LOOK], pair())


def an(name: str, at: str, shape: str = "cube", color: str = "red") -> str:
    size = "size: (10 cm, 10 cm, 10 cm)" if shape == "wedge" else "size: 10 cm"
    return OBJECT.format(name=name, shape=shape, color=color, at=at).replace("size: 10 cm", size)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_silhouette_is_what_the_engine_draws(shape: str) -> None:
    observed = seen(an("a", "-20 cm, 5 cm", shape))
    i = observed.index("a")
    outline = visibility.outline(observed, i, LOOK)
    drawn = int((observed.picture(*LOOK).ids == i).sum())
    assert outline.inside == outline.all
    assert drawn == pytest.approx(outline.inside, rel=0.05, abs=6)
    assert visibility.occluded(observed, "a", "front") < 0.05
    assert visibility.hidden_share_bound(observed, i, LOOK) >= visibility.hidden_share(observed, i, LOOK)
    assert visibility.visible(observed, "a", "front") == drawn / observed.picture(*LOOK).ids.size


def test_half_of_it_is_behind_another() -> None:
    observed = seen(an("near", "5 cm, 0 cm", color="blue"), an("far", "0 cm, 11 cm"))
    hidden = visibility.occluded(observed, "far", "front")
    ids, i = observed.picture(*LOOK).ids, observed.index("far")
    assert 0.2 < hidden < 0.6
    alone = int((seen(an("far", "0 cm, 11 cm")).picture(*LOOK).ids == i - 1).sum())
    assert hidden == pytest.approx(1 - (ids == i).sum() / alone, abs=0.05)
    assert visibility.occluded(observed, "near", "front") < 0.05
    assert 1 > visibility.hidden_share_bound(observed, i, LOOK) >= hidden


def test_the_same_color_does_not_stand_out() -> None:
    oak, red = seen(an("a", "0, 0", color="oak")), seen(an("a", "0, 0", color="red"))
    contrasts = [visibility.contrast(o, "a", "front") for o in (oak, red)]
    assert contrasts[0] < 20 < contrasts[1], contrasts


def test_body_outside_the_picture_has_no_silhouette() -> None:
    observed = seen(an("a", "0, 0"), "object b { size: 10 cm  at: (0, -3 m, 1 m)  fixed: true }")
    i = observed.index("b")
    outline = visibility.outline(observed, i, LOOK)
    assert (outline.inside, outline.all) == (0, 0)
    assert visibility.hidden_share(observed, i, LOOK) == visibility.hidden_share_bound(observed, i, LOOK) == 1
    assert visibility.contrast(observed, "b", "front") == 0


def test_half_outside_the_frame() -> None:
    narrow = "camera eye { at: (0, -1 m, 60 cm)  look_at: (0, 0, 0)  fov: 20 deg }"
    at = np.arange(0, 40)
    shares = []
    for x in at:
        observed = run(
            f"{an('a', f'{x} cm, 0')} {narrow} observe eye at [0 s]"
        ).observed([("eye", 0.0)], pair())  # fmt: skip
        outline = visibility.outline(observed, observed.index("a"), ("eye", 0.0))
        if outline.inside == 0:
            break
        shares.append(outline.inside / outline.all)
    assert shares[0] == 1
    assert 0 < min(shares) < 0.4
    assert all(a >= b - 0.02 for a, b in pairwise(shares))


QUESTION = 'question "Which is larger, {{a}} or {{b}}?" {{ options [a, b]  answer {answer} }}'
TWO = """object a {{ size: 8 cm  color: {color}  on: table at ({at}) }}
  object b {{ size: 6 cm  color: blue  on: table at (20 cm, 0) }}"""
WALL = "object wall { shape: box  size: (14 cm, 2 cm, 20 cm)  color: white  on: table at (20 cm, 12 cm)  fixed: true }"


@pytest.mark.parametrize(
    ("color", "at", "why"),
    [
        ("red", "-20 cm, 0", ""),
        ("red", "26 cm, 20 cm", "of it is hidden"),
        ("red", "-44 cm, -32 cm", "outside the frame"),
        ("red", "20 cm, 20 cm", ": it is hidden behind wall"),
        ("red", "-52 cm, -32 cm", ": it is outside the frame"),
    ],
)
def test_objects_of_the_question_must_be_seen(color: str, at: str, why: str) -> None:
    body = f"{TWO.format(color=color, at=at)} {WALL} observe front at [0 s] {QUESTION.format(answer='largest([a, b])')}"
    if why:
        assert why in refused(body)
        assert refused(body).startswith("unseen: a from front at 0 s")
    else:
        assert one(body).value == "the red cube"


RIDE = """
  object cart  { shape: box  size: (16 cm, 10 cm, 6 cm)  color: blue  on: table at (-40 cm, 0) }
  object block { size: 8 cm  color: red  on: table at (%s) }
  camera eye { ride: cart  at: (0, 0, 12 cm)  look_at: (1 m, 0, 0)  fov: 50 deg }
  action go = glide(cart, direction: 0 deg, speed: 20 cm/s) for 1 s
  observe %s at [0 s, 1 s]
  question "Does it come near {block}?" { answer distance(cart, block) < 30 cm }
"""


def test_riding_camera_must_see_an_object_once() -> None:
    """What carries it need not be seen, and is not."""
    assert one(RIDE % ("0, 0", "eye")).value == "yes"
    assert one(RIDE % ("-10 cm, 12 cm", "eye")).value == "yes", "seen at first, passed at last"
    assert refused(RIDE % ("-50 cm, 20 cm", "eye")).startswith("unseen: block from eye at 0 s: 0 of")


def test_silhouette_uses_the_pose_of_the_camera() -> None:
    observed = run(RIDE % ("0, 0", "eye")).observed([("eye", 0.0), ("eye", 1.0)], pair())
    i = observed.index("block")
    for view in observed.views:
        drawn = int((observed.picture(*view).ids == i).sum())
        assert drawn == pytest.approx(visibility.outline(observed, i, view).inside, rel=0.05, abs=6)
    assert visibility.visible(observed, "block", "eye") == pytest.approx(
        visibility.visible_share(observed, i, ("eye", 0.0))
    )


SCREEN = "object wall { shape: box  size: (80 cm, 4 cm, 40 cm)  color: gray  on: table at (0, -10 cm) }"


@pytest.mark.parametrize(
    "answer", ["ball.color", "shade", "if ball.color == red then red else blue", "tone"], ids=lambda a: a.split()[0]
)
@pytest.mark.parametrize("wall", ["", SCREEN], ids=["open", "hidden"])
def test_objects_of_the_answer_must_be_seen_under_any_name(answer: str, wall: str) -> None:
    """A text that says `the ball` without braces, and an answer by a `let` or by the factor that decides the colour."""
    body = f"""
      factor tone in [red, blue]
      let shade = ball.color
      object ball {{ shape: sphere  size: 8 cm  color: tone  on: table at (0, 10 cm) }}
      {wall}
      observe front at [0 s]
      question "What colour is the ball?" {{ options [red, blue]  answer {answer} }}
    """
    if wall:
        assert refused(body).startswith("unseen: ball")
    else:
        assert one(body).value == "red"
