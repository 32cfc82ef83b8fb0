"""The doctor finds what is broken, and names the remedy."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import wmspec
from wmspec.cli import main
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.doctor import doctor, install_hints, probe
from wmspec.runtime.doctor.doctor import Finding, examine, fit
from wmspec.runtime.doctor.install_hints import System
from wmspec.runtime.doctor.probe import render
from wmspec.sim.photo import library
from wmspec.sim.scene.render.camera import look_at

BOOKWORM = System(frozenset({"debian"}), "bookworm", root=True)
TRIXIE = System(frozenset({"debian"}), "trixie", root=False)
UBUNTU = System(frozenset({"ubuntu", "debian"}), "plucky", root=False)
FEDORA = System(frozenset({"fedora"}), "", root=False)


def only(monkeypatch: pytest.MonkeyPatch, *engines: str) -> None:
    """Let the doctor look at some engines: drawing with all of them takes long."""
    monkeypatch.setattr(doctor, "names", lambda: engines)
    monkeypatch.setattr(doctor, "_photo", lambda *_: [])


def by_name(findings: tuple[Finding, ...]) -> dict[str, Finding]:
    return {f.name: f for f in findings}


def test_a_healthy_engine_executes_and_renders(monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, "pybullet")
    findings = examine()
    assert fit(findings)
    found = by_name(findings)
    assert found["pybullet executes"].found.startswith("a cube fell 49")
    assert "red cube" in found["pybullet renders"].found
    assert all(f.ok == (f.remedy == "") for f in findings)


def test_a_bad_mujoco_gl_is_to_be_unset(monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, "mujoco")
    monkeypatch.setenv("MUJOCO_GL", "bogus")
    found = by_name(examine())
    for name in ("mujoco executes", "mujoco renders"):  # with an unknown name MuJoCo cannot even be imported
        assert not found[name].ok
        assert "bogus" in found[name].found
        assert found[name].remedy == "unset MUJOCO_GL"


def test_drivers_pointed_nowhere_are_to_be_unset(monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, "sapien")
    monkeypatch.setenv("VK_DRIVER_FILES", "/nowhere.json")
    result = CliRunner().invoke(main, ["doctor"])
    assert result.exit_code == 1
    marks = {line[4:].split("  ")[0]: line[:2] for line in result.output.splitlines() if line[:2] in {"ok", "--"}}
    assert (marks["sapien executes"], marks["sapien renders"]) == ("ok", "--")
    assert "to fix sapien renders:\n  unset VK_DRIVER_FILES\n" in result.output
    assert result.output.count("unset") == 1


def test_a_trial_that_takes_too_long_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, "pybullet")
    found = by_name(examine(patience=0.01))
    assert found["pybullet renders"].found == "no answer in 0 s"
    assert found["pybullet renders"].remedy == ""
    assert "report it" in found["pybullet renders"].report


def test_a_crash_is_a_finding(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "crashes.py").write_text("import os\nos.abort()\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    tried = doctor._try("crashes", patience=600)
    assert isinstance(tried, probe.Failure)
    assert (tried.words, tried.cause) == ("crashed (SIGABRT)", None)
    (file,) = (tmp_path / "wmspec/errors").iterdir()
    assert str(file) in tried.report
    assert "Fatal Python error: Aborted" in file.read_text()


def test_an_engine_that_is_not_installed(tmp_path: Path) -> None:
    """Every installed package but SAPIEN stands in a folder; an interpreter that sees only that runs the doctor."""
    for folder in map(Path, sys.path):
        if folder.name == "site-packages":
            for entry in folder.iterdir():
                if not entry.name.startswith("sapien") and not (tmp_path / entry.name).exists():
                    (tmp_path / entry.name).symlink_to(entry)
    code = (
        "from wmspec.runtime.doctor import doctor; doctor.names, doctor._photo = lambda: ('sapien',), lambda *_: []\n"
        "from wmspec.cli import main; main(['doctor', '--json'])"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(Path(wmspec.__file__).parents[1])])}
    done = subprocess.run(
        [sys.executable, "-S", "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1, done.stderr
    said: dict[str, Any] = json.loads(done.stdout)
    (sapien,) = [f for f in said["findings"] if f["name"].startswith("sapien")]
    assert sapien["found"] == "not installed"
    assert sapien["remedy"].endswith("-m pip install 'wmspec[sapien]'")


def test_the_photo_look_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mitsuba_oidn")
    monkeypatch.setattr(library, "newest_llvm", lambda: "")
    monkeypatch.delenv(library.LLVM, raising=False)
    found = by_name(tuple(doctor._photo(UBUNTU, 300)))
    assert found["photo"].found.startswith("mitsuba 3")
    assert found["photo renders"] == Finding("photo renders", True, "a red cube, by scalar_rgb")
    assert found["photo with LLVM"].remedy == "sudo apt-get update && sudo apt-get install libllvm19"


def test_an_llvm_that_will_not_do_is_to_be_unset(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mitsuba_oidn")
    monkeypatch.setenv(library.LLVM, "/nowhere.so")
    found = by_name(tuple(doctor._photo(UBUNTU, 300)))
    assert not found["photo renders"].ok
    assert found["photo renders"].remedy == f"unset {library.LLVM}"
    assert "photo with LLVM" not in found


def test_a_photo_look_that_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "DISTRIBUTIONS", ("no-such-package",))
    (finding,) = doctor._photo(UBUNTU, 300)
    assert (finding.found, finding.ok) == ("not installed", False)
    assert finding.remedy.endswith("-m pip install 'wmspec[photo]'")


def test_wrong_picture_is_never_right(monkeypatch: pytest.MonkeyPatch) -> None:
    away = look_at((0.0, -0.6, 1.1), (0.0, -2.0, 1.1))
    monkeypatch.setattr(probe, "look_at", lambda *_: away)
    with pytest.raises(WmsError, match="does not show it"):
        render("pybullet")


@pytest.mark.parametrize(
    ("system", "begins"),
    [
        (BOOKWORM, 'echo "deb $(apt-get indextargets'),
        (TRIXIE, "sudo apt-get update && sudo apt-get install mesa-vulkan-drivers"),
        (UBUNTU, "sudo apt-get update && sudo apt-get install mesa-vulkan-drivers"),
        (FEDORA, "install Mesa 24.3 or newer"),
    ],
)
def test_each_system_has_its_command(system: System, begins: str) -> None:
    assert install_hints.graphics(system, (24, 3)).startswith(begins)


def test_debian_12_takes_mesa_from_its_backports() -> None:
    command = install_hints.graphics(BOOKWORM, (24, 3))
    assert "-t bookworm-backports mesa-vulkan-drivers" in command
    assert "://" not in command, "the address is the system's own"
    assert subprocess.run(["bash", "-n", "-c", command], check=False).returncode == 0
