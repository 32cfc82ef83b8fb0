"""Checks every part of the installation by running it.

A recognised cause has a remedy. Any other failure is printed with instructions for a report.
"""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import PackageNotFoundError, requires, version
from itertools import chain

from wmspec.core.crash import Crash, how_to_report
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.doctor import install_hints, probe
from wmspec.runtime.doctor.install_hints import Cause, System
from wmspec.runtime.doctor.probe import Failure
from wmspec.runtime.engines.registry import engine_version, info, names
from wmspec.sim.photo import library
from wmspec.sim.scene.backend import Info

PATIENCE = 300.0  # s: an engine may compile its shaders in every process, which takes minutes on a busy machine
OLDEST_PYTHON = (3, 11)
#: The renderer of the look "photo", described like an engine.
_PHOTO = Info("photo", "Mitsuba", "mitsuba", "mitsuba", library.REQUIREMENT, 0)


@dataclass(frozen=True)
class Finding:
    """The result of one check: whether it passed, and what was found.

    A failed check has the command that fixes it, or, without a recognised cause, how to report it.
    """

    name: str
    ok: bool
    found: str
    remedy: str = ""
    report: str = ""


def examine(patience: float = PATIENCE) -> tuple[Finding, ...]:
    """Check Python, packages, and each engine by executing and rendering a cube.

    No trial takes longer than `patience` (s). Failures are findings, not exceptions.
    """
    system = install_hints.this_system()
    known = {name: _known(name) for name in names()}
    engines = [engine for engine in known.values() if not isinstance(engine, Finding)]
    looks: list[Callable[[], Sequence[Finding]]] = [
        lambda: [_python()],
        lambda: [_packages()],
        lambda: [finding for finding in known.values() if isinstance(finding, Finding)],
        *(partial(_engine, engine, system, patience) for engine in engines),
        partial(_photo, system, patience),
    ]
    with ThreadPoolExecutor() as pool:
        return tuple(chain.from_iterable(pool.map(lambda look: look(), looks)))


def _known(name: str) -> Info | Finding:
    """Return the description of a backend, or a finding that it cannot be loaded."""
    try:
        return info(name)
    except WmsError as error:
        return _failed(Finding(name, False, ""), Failure.of(error), None)


def _failed(finding: Finding, failure: Failure, fixed: Callable[[Cause], str] | None) -> Finding:
    """Return a failed finding, with the remedy of its cause, or else how to report it."""
    cure = fixed(failure.cause) if failure.cause and fixed else ""
    report = "" if cure else failure.report or f"  {how_to_report(file=False)}"
    return replace(finding, ok=False, found=failure.words, remedy=cure, report=report)


def fit(findings: Sequence[Finding]) -> bool:
    """Whether at least one engine both executes and renders."""
    well = {f.name for f in findings if f.ok}
    return any({f"{engine} executes", f"{engine} renders"} <= well for engine in names())


def _python() -> Finding:
    version = ".".join(map(str, sys.version_info[:3])) + f" at {sys.executable}"
    ok = sys.version_info >= OLDEST_PYTHON
    return Finding("Python", ok, version, "" if ok else "make a virtual environment with Python 3.11 or newer")


def _packages() -> Finding:
    """Check the core requirements that wmspec declares, and wmspec itself."""
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
    """Whether the requirement's package is installed, and new enough."""
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
    trials = ("execute", "render") if engine.draws else ("execute",)
    return [installed, *(_trial(engine, trial, system, patience) for trial in trials)]


def _photo(system: System, patience: float) -> list[Finding]:
    """Check whether the look "photo" can be rendered, and whether an LLVM accelerates it."""
    try:
        installed = Finding("photo", True, ", ".join(f"{name} {version(name)}" for name in library.DISTRIBUTIONS))
    except PackageNotFoundError:
        return [Finding("photo", False, "not installed", install_hints.pip(library.REQUIREMENT))]
    forced = bool(os.environ.get(library.LLVM))
    tried = _try("wmspec.runtime.doctor.probe", "mitsuba", "photo", patience=patience)
    drawn = Finding("photo renders", True, "" if isinstance(tried, Failure) else tried)
    if isinstance(tried, Failure):
        drawn = _failed(drawn, tried, partial(_photo_fixed, system=system))
    return [installed, drawn] if forced or not drawn.ok else [installed, drawn, _compiling(system, patience)]


def _photo_fixed(cause: Cause, system: System) -> str:
    """Return the command that fixes the renderer of the look "photo"."""
    if cause.kind == "install":
        return install_hints.pip(library.REQUIREMENT, "--force-reinstall")
    return install_hints.mending(cause, _PHOTO, system)


def _compiling(system: System, patience: float) -> Finding:
    """Try the newest LLVM of this machine; it is optional."""
    path = library.newest_llvm()
    if not path:
        needed = f"no LLVM {library.OLDEST_LLVM} or newer; pictures are drawn without, which takes longer"
        return Finding("photo with LLVM", False, needed, install_hints.llvm(system, library.OLDEST_LLVM))
    tried = _try("wmspec.runtime.doctor.probe", "mitsuba", "photo", patience=patience, **{library.LLVM: path})
    if isinstance(tried, Failure):
        failure = replace(tried, words=f"{path}: {tried.words}")
        return _failed(
            Finding("photo with LLVM", False, ""), failure, lambda _: install_hints.llvm(system, library.OLDEST_LLVM)
        )
    return Finding("photo with LLVM", True, f"{tried}; it is used after: export {library.LLVM}={path}")


def _trial(engine: Info, trial: str, system: System, patience: float) -> Finding:
    tried = _try("wmspec.runtime.doctor.probe", engine.name, trial, patience=patience)
    if not isinstance(tried, Failure):
        return Finding(f"{engine.name} {trial}s", True, tried)
    return _failed(
        Finding(f"{engine.name} {trial}s", False, ""), tried, lambda cause: install_hints.mending(cause, engine, system)
    )


def _try(module: str, *arguments: str, patience: float, **variables: str) -> str | Failure:
    """Run a module in its own process with extra variables; return its last output, or the failure."""
    command = [sys.executable, "-P", "-X", "faulthandler", "-m", module, *arguments]
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
        return Failure(f"no answer in {patience:.0f} s")
    if done.returncode < 0:
        words = f"crashed ({signal.Signals(-done.returncode).name})"
        crash = Crash(words, "", words, f"{shlex.join(command)}\n{done.stderr}")
        return Failure(words, report=crash.advice(crash.save()))
    last = (done.stdout.strip() or done.stderr.strip() or "nothing was said").splitlines()[-1]
    if last.startswith(probe.FAILED):
        return Failure.read(last.removeprefix(probe.FAILED))
    return last.removeprefix(probe.FOUND) if done.returncode == 0 else Failure(last)
