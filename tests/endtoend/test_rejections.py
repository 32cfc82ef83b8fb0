"""Failures are data: what cannot be asked is counted with its reason."""

import json
from pathlib import Path

import pytest

from tests.command import wmspec
from tests.engines import installed

SPEC = """
use tabletop
task still : custom {{
  factor pace in [0, 20] cm/s
  object a {{ shape: sphere  size: 8 cm  color: red  on: table at (-20 cm, 12 cm) }}
  object b {{ shape: sphere  size: 8 cm  color: blue  at: ({where}, -12 cm, 4 cm) }}
  action go_a = glide(a, direction: 0 deg, speed: 10 cm/s) for 1 s
  action go_b = glide(b, direction: 0 deg, speed: pace) for 1 s
  observe front at [0 s, 1 s]
  question "Which is faster?" {{ options [a, b]  answer fastest([a, b])  {gate} }}
}}
"""


@pytest.mark.parametrize(
    ("gate", "where", "reason", "kept"),
    [
        ("", "-20 cm", "", 2),
        ("margin speed(a) / speed(b) apart by 1.1", "-20 cm", "invalid", 1),
        ("margin speed(a) - speed(b) apart by 11 cm/s", "-20 cm", "margin", 0),
        ("ensure displacement(b) > 5 cm", "-20 cm", "ensure", 1),
        ("", "2 m", "unseen", 0),
    ],
)
def test_impossible_questions_are_counted(gate: str, where: str, reason: str, kept: int, tmp_path: Path) -> None:
    installed("pybullet")
    (tmp_path / "still.wms").write_text(SPEC.format(gate=gate, where=where))
    command = ["generate", "still.wms", "-o", "out", "-b", "pybullet", "--size", 64, "-j", 1]
    done = wmspec(*command, folder=tmp_path, code=0 if kept else 1)
    assert ("error: no question was kept" in done.stderr) == (kept == 0)
    manifest = json.loads((tmp_path / "out/manifest.json").read_text())
    assert manifest["tasks"]["still"]["rows"] == {"questions": kept}
    reported = manifest["rejected"]["list"]
    assert {r["reason"] for r in reported} == ({reason} if reason else set())
    assert all(r["detail"] for r in reported)
    for r in reported[:1]:
        assert f"  {len(reported)} {reason}, such as instance {r['index']} in pybullet: {r['detail']}" in done.stdout
        (task,) = json.loads(wmspec(*command, "--json", folder=tmp_path, code=done.exit_code).stdout)
        assert task["examples"][reason] == r
        dry = [*(word for word in command if word not in ("-o", "out")), "--dry-run"]
        assert f"  {len(reported)} {reason}, such as" in wmspec(*dry, folder=tmp_path).stdout


ROBOT = """
use tabletop
task grab : custom {
  object cup { size: 5 cm  on: table at (0, 0) }
  robot truck : car { on: floor at (-3 m, 0) }
  action go = truck.forward(distance: 15 cm) for 1 s
  observe front at [0 s, 1 s]
  question "Is it held?" { answer moved(cup) }
}
"""


def test_failed_plan_is_refused_with_its_place(tmp_path: Path) -> None:
    installed("pybullet")
    (tmp_path / "grab.wms").write_text(ROBOT)
    for command in (["check", "grab.wms"], ["run", "grab.wms", "-b", "pybullet"]):
        reported = wmspec(*command, folder=tmp_path, code=2).stderr
        assert "`truck` cannot forward so: it has no roads" in reported
        assert "grab.wms:6:10" in reported
    made = wmspec("generate", "grab.wms", "-o", "out", "-b", "pybullet", "-j", 1, folder=tmp_path, code=1).stdout
    assert "1 rejected (1 invalid)" in made
    assert "`truck` cannot forward so: it has no roads" in made
