"""The table of capabilities is what is refused, printed and documented."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from click.testing import CliRunner

from wmspec.cli import main
from wmspec.scene.capability import NAMES, NEVER, RATES, TABLE

ROOT = Path(__file__).parents[2]


def test_the_page_is_current() -> None:
    subprocess.run([sys.executable, "tools/capabilities.py", "--check"], cwd=ROOT, check=True)


def test_doctor_prints_it() -> None:
    shown = CliRunner().invoke(main, ["doctor", "--capabilities"])
    assert shown.exit_code == 0
    assert all(row.name in shown.output for row in (*TABLE, *NEVER))
    found = json.loads(CliRunner().invoke(main, ["doctor", "--capabilities", "--json"]).output)
    lacking = {row["capability"]: set(row["lacking"]) for row in found}
    assert lacking["ball joints with limits"] == {"mujoco", "pybullet"}


def test_every_reason_names_an_engine_that_there_is() -> None:
    assert all(set(row.lacking) <= set(NAMES) for row in TABLE)


def test_the_rates_are_those_of_the_engines() -> None:
    for engine, rate in RATES.items():
        pytest.importorskip(engine)
        assert rate == import_module(f"wmspec.backends.{engine}.execute").STEPS_PER_SECOND
