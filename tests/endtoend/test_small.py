"""Small things that commands and messages once said wrongly."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import wmspec
from tests.engines import installed
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.dataset.build.format_units import format_value
from wmspec.lang.check.statements.builder import observe, task, thing
from wmspec.runtime.questions.verbalize import verbalize

BALL = "object ball { shape: sphere  size: 6 cm  color: red  on: table }"
SPEC = "use tabletop\ntask t : custom {{ factor n in [1, 2]  {body}  observe front at [0 s, 0.1 s] }}"
TRAY = """
use floor
task t : custom {
  factor n in [1, 2]
  object tray {
    color: oak  on: floor at (10 cm * n, 0)
    part base { shape: box  size: (20 cm, 20 cm, 2 cm)  at: (0, 0, 1 cm) }
    part side { shape: box  size: (2 cm, 20 cm, 8 cm)  at: (9 cm, 0, 6 cm) }
  }
  camera eye { at: (0, -1 m, 1 m) }
  observe eye at [0 s]
  horizon 0.1 s
}
"""


def command(*arguments: object, text: str | None = None) -> subprocess.CompletedProcess[str]:
    """`wmspec` with these arguments, and this standard input."""
    line = [sys.executable, "-m", "wmspec", *map(str, arguments)]
    return subprocess.run(line, input=text, capture_output=True, text=True, check=False)


def place_of_the_ball(instance: wmspec.Instance) -> tuple[list[float], str]:
    """Where its prim is (m), and what the stage says decides that."""
    stage = instance.stage()
    ball = next(prim for prim in stage.Traverse() if prim.GetName() == "ball")
    place = ball.GetAttribute("xformOp:translate")
    return list(place.Get()), place.GetCustomDataByKey("wms:from")


def test_check_reads_standard_input() -> None:
    good = command("check", "-", text=SPEC.format(body=BALL))
    assert (good.returncode, "t: 2 instances" in good.stdout) == (0, True)
    bad = command("check", "--json", "-", text=SPEC.format(body=BALL.replace("red", "rad")))
    (reported,) = json.loads(bad.stdout)["diagnostics"]
    assert bad.returncode == 2
    assert "rad" in reported["message"]


def test_without_on_a_place_on_the_ground_is_stood_on() -> None:
    """`at: (x, y)`: what the page on the language says."""
    body = "object ball { shape: sphere  size: 6 cm  color: red  at: (10 cm, 5 cm) }"
    (first, _) = wmspec.load(text=SPEC.format(body=body + "  let k = n"))
    assert place_of_the_ball(first)[0] == pytest.approx([0.1, 0.05, 0.03])


def test_page_explains_sources_in_stages() -> None:
    (first, _) = wmspec.load(text=SPEC.format(body=BALL))
    assert place_of_the_ball(first)[1] == "ball.pose"
    assert '`customData["wms"]["from"]`' in (Path(__file__).parents[2] / "docs/stage.md").read_text()


@pytest.mark.engine
def test_run_reports_the_middle_of_a_compound_like_measures(tmp_path: Path) -> None:
    installed("mujoco")
    (tmp_path / "t.wms").write_text(TRAY)
    (found,) = json.loads(command("run", tmp_path / "t.wms", "-b", "mujoco", "--json").stdout)
    tray = found["bodies"]["tray"]
    assert tray["position"] == pytest.approx([0.1, 0, 0], abs=1e-3)
    assert tray["middle"] == pytest.approx([0.1, 0, 0.05], abs=1e-3)
    assert "0.0,    5.0) cm" in command("run", tmp_path / "t.wms", "-b", "mujoco").stdout


@pytest.mark.parametrize(("mass", "words"), [(0.2, "200 g"), (0.9994, "999.4 g"), (1.0, "1 kg"), (1.5, "1.5 kg")])
def test_mass_is_verbalized_in_usual_units(mass: float, words: str) -> None:
    values = Evaluator(task("t", thing("camera", "front", at=(0, -1, 1)), observe("front", [0.0])), {})
    assert verbalize(mass, "mass", values) == words
    assert mass < 1 or format_value(mass, "kg") == words


def test_closed_pipe_is_no_failure() -> None:
    """As of what SIGPIPE ends, not 1, which says that a check failed; and nothing is printed."""
    reads, writes = os.pipe()
    os.close(reads)
    line = [sys.executable, "-m", "wmspec", "schema"]
    done = subprocess.run(line, stdout=writes, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writes)
    assert (done.returncode, done.stderr) == (141, "")


def test_missing_camera_is_one_sentence() -> None:
    from wmspec.core.diagnostics import WmsError
    from wmspec.sim.scene.render.camera import find_camera
    from wmspec.sim.usd import read

    (first, _) = wmspec.load(text=SPEC.format(body=BALL))
    with pytest.raises(WmsError, match=r"there is no camera `frnt`; did you mean `front`\?"):
        find_camera(read(first.stage()), "frnt")


def test_redundant_distinct_by_is_reported() -> None:
    for tail in ("answer moved(ball)", "answer height(ball)  within 1 cm"):
        body = BALL + f'question "Does it?" {{ {tail}  distinct by 3 cm }}'
        with pytest.raises(wmspec.SpecError, match="`distinct by` is for options that are pictures"):
            wmspec.load(text=SPEC.format(body=body))


@pytest.mark.parametrize(("word", "intended"), [("weight", "mass"), ("colour", "color"), ("bounciness", "restitution")])
def test_other_words_for_properties_are_known(word: str, intended: str) -> None:
    with pytest.raises(wmspec.SpecError) as caught:
        wmspec.load(text=SPEC.format(body=BALL.replace("on:", f"{word}: 1  on:")))
    assert [d.help for d in caught.value.diagnostics] == [f"did you mean `{intended}`?"]
