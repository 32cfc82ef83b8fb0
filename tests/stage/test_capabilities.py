"""The table of capabilities is what is refused and printed."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace

import pytest
from click.testing import CliRunner

from tests.engines import ENGINES, installed
from tests.physics.scenes import body, floor, scene
from wmspec.cli import main
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.doctor.probe import falling_cube
from wmspec.runtime.engines.registry import engine_version, info, names
from wmspec.sim.scene.capability import JOINTS, NEVER_SUPPORTED, Lack, capability_table, friction_above, require
from wmspec.sim.scene.model import Joint
from wmspec.sim.scene.model.transform import identity
from wmspec.sim.shapes import Sphere


def test_doctor_lists_the_engine() -> None:
    shown = CliRunner().invoke(main, ["doctor", "--capabilities"])
    assert shown.exit_code == 0
    assert all(name in shown.output for name, _ in capability_table({n: info(n).lacks for n in names()}))
    found = json.loads(CliRunner().invoke(main, ["doctor", "--capabilities", "--json"]).output)
    lacking = {row["capability"]: set(row["lacking"]) for row in found}
    assert lacking["ball joints with limits"] == {"mujoco", "pybullet", "sapien"}


@pytest.mark.parametrize("engine", ENGINES)
def test_a_cone_that_an_engine_lets_joints_pass_is_refused(engine: str) -> None:
    hanging = body("b", Sphere(0.1))
    free = Joint("hook", "/World/hook", "ball", None, "b", identity(), identity())
    require(info(engine).lacks, scene(hanging, joints=(free,)))
    with pytest.raises(WmsError, match="a ball joint with limits"):
        require(info(engine).lacks, scene(hanging, joints=(replace(free, limits=(0.5, 0.5)),)))


@pytest.mark.parametrize("engine", ENGINES)
def test_engine_description_is_true(engine: str) -> None:
    said = info(engine)
    assert said.name == engine
    assert len({lack.capability.name for lack in said.lacks}) == len(said.lacks)
    episode = installed(engine).execute(falling_cube())
    assert episode.engine == engine
    assert engine_version(engine)


def test_engine_descriptions_need_no_import() -> None:
    code = (
        "import sys; from wmspec.runtime.engines.registry import info, names\n"
        "print([m for m in [info(n).module for n in names()] if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_each_unsupported_capability_is_refused() -> None:
    rows = capability_table({"one": (Lack(JOINTS, "no joints"),), "other": (Lack(friction_above(2), "slippery"),)})
    lacking = {name: reasons for name, reasons in rows if name not in NEVER_SUPPORTED and any(reasons.values())}
    assert lacking == {
        JOINTS.name: {"one": "no joints", "other": ""},
        "friction above 2": {"one": "", "other": "slippery"},
    }
    rough = scene(body("rough", Sphere(0.1), friction=3.0), floor())
    require((Lack(friction_above(3), "slippery"),), rough)
    with pytest.raises(WmsError, match=r"/World/rough: friction 3, above 2; slippery"):
        require((Lack(friction_above(2), "slippery"),), rough)
