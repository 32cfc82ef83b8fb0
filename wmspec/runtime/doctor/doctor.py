"""What works on this machine, and what mends the rest: nothing is guessed, everything is tried."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, requires, version
from itertools import chain

from wmspec.runtime.doctor import install_hints, probe
from wmspec.runtime.doctor.install_hints import System
from wmspec.runtime.engines.registry import engine_version, info, names
from wmspec.sim.photo import library
from wmspec.sim.scene.backend import Info

PATIENCE = 300.0  # seconds: an engine may compile its shaders anew in every process, minutes on a busy machine
OLDEST_PYTHON = (3, 11)


@dataclass(frozen=True)
class Finding:
    """One thing looked at: whether it is well, what was found, and the command that mends it (empty if it is well)."""

    name: str
    ok: bool
    found: str
    remedy: str = ""


def examine(patience: float = PATIENCE) -> tuple[Finding, ...]:
    """Look at everything: Python, packages, and each engine by letting it execute and draw a cube.

    No trial takes longer than `patience` (s). Never raises for what it finds.
    """
    system = install_hints.this_system()
    engines = [info(name) for name in names()]
    looks: list[Callable[[], Sequence[Finding]]] = [
        lambda: [_python()],
        lambda: [_packages()],
        *(partial(_engine, engine, system, patience) for engine in engines),
        partial(_photo, system, patience),
    ]
    with ThreadPoolExecutor() as pool:
        return tuple(chain.from_iterable(pool.map(lambda look: look(), looks)))


def fit(findings: Sequence[Finding]) -> bool:
    """Whether at least one engine both executes and renders."""
    well = {f.name for f in findings if f.ok}
    return any({f"{engine} executes", f"{engine} renders"} <= well for engine in names())


def _python() -> Finding:
    version = ".".join(map(str, sys.version_info[:3])) + f" at {sys.executable}"
    ok = sys.version_info >= OLDEST_PYTHON
    return Finding("Python", ok, version, "" if ok else "make a virtual environment with Python 3.11 or newer")


def _packages() -> Finding:
    """The core requirements that wmspec itself declares, and wmspec."""
    try:
        declared = [r for r in requires("wmspec") or () if "extra ==" not in r]
    except PackageNotFoundError:
        return Finding("packages", False, "wmspec itself is not installed", f"{sys.executable} -m pip install -e .")
    lacking = [r for r in declared if not _satisfied(r)]
    if lacking:
        return Finding("packages", False, f"missing or too old: {', '.join(lacking)}", install_hints.pip("wmspec"))
    return Finding("packages", True, ", ".join(f"{n} {version(n)}" for n in ["wmspec", *map(_name, declared)]))


def _name(requirement: str) -> str:
    return re.split(r"[^\w.-]", requirement, maxsplit=1)[0]


def _satisfied(requirement: str) -> bool:
    """Whether the requirement's package is installed, and at least as new as it says."""
    try:
        installed = version(_name(requirement))
    except PackageNotFoundError:
        return False
    least = re.search(r">=\s*([\d.]+)", requirement)
    return least is None or _numbers(installed) >= _numbers(least[1])


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(int(n) for n in re.findall(r"\d+", text)[:3])


# ---------------------------------------------------------------- engines


def _engine(engine: Info, system: System, patience: float) -> list[Finding]:
    name = engine.name
    try:
        installed = Finding(name, True, engine_version(name))
    except PackageNotFoundError:
        return [Finding(name, False, "not installed", install_hints.engine_package(engine, system))]
    findings = [installed, _trial(name, "execute", install_hints.executing(engine, system), patience)]
    if engine.draws:
        findings.append(_trial(name, "render", install_hints.drawing(engine, system), patience))
    return findings


def _photo(system: System, patience: float) -> list[Finding]:
    """Whether the look "photo" can be drawn, and whether an LLVM here makes that faster."""
    try:
        installed = Finding("photo", True, ", ".join(f"{name} {version(name)}" for name in library.DISTRIBUTIONS))
    except PackageNotFoundError:
        return [Finding("photo", False, "not installed", install_hints.pip(library.REQUIREMENT))]
    forced = f"unset {library.LLVM}" if os.environ.get(library.LLVM) else ""
    cure = forced or install_hints.pip(library.REQUIREMENT, "--force-reinstall")
    ok, output = _try("wmspec.runtime.doctor.probe", "mitsuba", "photo", patience=patience)
    drawn = Finding("photo renders", ok, output, "" if ok else cure)
    return [installed, drawn] if forced else [installed, drawn, _compiling(system, patience)]


def _compiling(system: System, patience: float) -> Finding:
    """The newest LLVM of this machine, tried."""
    path = library.newest_llvm()
    if not path:
        needed = f"no LLVM {library.OLDEST_LLVM} or newer; pictures are drawn without, which takes longer"
        return Finding("photo with LLVM", False, needed, install_hints.llvm(system, library.OLDEST_LLVM))
    ok, output = _try("wmspec.runtime.doctor.probe", "mitsuba", "photo", patience=patience, **{library.LLVM: path})
    if not ok:
        return Finding("photo with LLVM", False, f"{path}: {output}", install_hints.llvm(system, library.OLDEST_LLVM))
    return Finding("photo with LLVM", True, f"{output}; it is used after: export {library.LLVM}={path}")


def _trial(engine: str, trial: str, cure: str, patience: float) -> Finding:
    ok, output = _try("wmspec.runtime.doctor.probe", engine, trial, patience=patience)
    return Finding(f"{engine} {trial}s", ok, output, "" if ok else cure)


def _try(module: str, *arguments: str, patience: float, **variables: str) -> tuple[bool, str]:
    """Run a module in a process of its own, with variables set: whether it ended well, and its last words."""
    command = [sys.executable, "-P", "-m", module, *arguments]
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=patience,
            check=False,
            env=os.environ | variables,
        )
    except subprocess.TimeoutExpired:
        return False, f"no answer in {patience:.0f} s"
    if done.returncode < 0:
        return False, f"crashed ({signal.Signals(-done.returncode).name})"
    words = (done.stdout.strip() or done.stderr.strip()).splitlines() or ["nothing was said"]
    return done.returncode == 0, words[-1].removeprefix(probe.FOUND).removeprefix(probe.FAILED)
