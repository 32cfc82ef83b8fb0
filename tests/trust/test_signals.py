"""A run that receives a signal ends quietly, and continues when it is started again."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SPEC = ROOT / "tests/endtoend/specs/speed_tabletop.wms"


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_interrupted_run_prints_no_traceback(tmp_path: Path, number: signal.Signals) -> None:
    out = tmp_path / "out"
    command = ["generate", SPEC, "-o", out, "-b", "mujoco", "--per-task", "400", "--size", "32", "-j", "2"]
    heard = signal.signal(signal.SIGINT, signal.default_int_handler)  # which a shell has jobs in the background ignore
    run = subprocess.Popen(
        [sys.executable, "-m", "wmspec", *map(str, command)], stderr=subprocess.PIPE, text=True, env=os.environ.copy()
    )
    signal.signal(signal.SIGINT, heard)
    while run.poll() is None and not list(out.glob(".progress/*/*/*.instance")):
        time.sleep(0.05)
    run.send_signal(number)
    _, reported = run.communicate()
    assert run.returncode == 128 + number
    assert "semaphore" not in reported
    assert "Traceback" not in reported
    assert list(out.glob(".progress/*/*/*.instance"))


TWICE = """
import signal
import click
from wmspec.cli import main

def interrupted(*_, **__):
    signal.raise_signal(signal.SIGINT)

signal.signal(signal.SIGINT, signal.default_int_handler)
click.Group.invoke = click.echo = interrupted
main(["list"])
"""


WRAPPED = """
import signal
import click
from wmspec.cli import main

def wrapped(*_, **__):
    try:
        signal.raise_signal(signal.{name})
    except BaseException as error:
        raise ValueError("SchemaError") from error

signal.signal(signal.SIGINT, signal.default_int_handler)
click.Group.invoke = wrapped
main(["list"])
"""


#: A module that drops what is raised while it is imported, and then does not end by itself.
DROPPING = """
import signal
try:
    signal.raise_signal(signal.{name})
except BaseException:
    print("dropped")
"""


IMPORTING = """
import signal
import time
import click
from wmspec.cli import main

def imported(*_, **__):
    import dropping
    time.sleep(60)

signal.signal(signal.SIGINT, signal.default_int_handler)
click.Group.invoke = imported
main(["list"])
"""


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_during_an_import_ends_the_run_after_it(name: str, tmp_path: Path) -> None:
    """USD imports modules in native code, which prints and drops the exception of a signal: the run went on."""
    (tmp_path / "dropping.py").write_text(DROPPING.format(name=name))
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-c", IMPORTING]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=50)
    assert (done.returncode, done.stdout, done.stderr.strip() or "stopped") == (
        128 + getattr(signal, name), "", "stopped",
    )  # fmt: skip


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_that_a_library_turns_into_an_error_of_its_own(name: str) -> None:
    """Pydantic did, while a module was imported; it was reported as a mistake of wmspec."""
    command = [sys.executable, "-c", WRAPPED.format(name=name)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (128 + getattr(signal, name), "")


def test_ctrl_c_ends_a_run_once() -> None:
    done = subprocess.run([sys.executable, "-c", TWICE], capture_output=True, text=True, check=False)
    assert done.returncode == 128 + signal.SIGINT
    assert done.stderr == ""
