"""Commands that fix an installation: Python packages with pip, graphics libraries with the system's packages."""

from __future__ import annotations

import os
import platform
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from wmspec.core.crash import is_own_error
from wmspec.core.diagnostics import GraphicsError
from wmspec.sim.scene.backend import Graphics, Info

PACKAGES = "mesa-vulkan-drivers libegl-mesa0 libgl1-mesa-dri libegl1 libgl1 libvulkan1"
DEBIAN_WITH_OLD_MESA = {"bookworm": "bookworm-backports"}  # Debian 12: Mesa 22.3, and 25.0 in its backports
FAMILY = {"debian", "ubuntu"}


@dataclass(frozen=True)
class System:
    """What determines how packages are installed: the names in os-release, and whether the user is root."""

    ids: frozenset[str]
    codename: str
    root: bool

    @property
    def sudo(self) -> str:
        """Prefix of system commands."""
        return "" if self.root else "sudo "


@dataclass(frozen=True)
class Cause:
    """A recognised cause, and the package, library, engine module or variable that it concerns."""

    kind: Literal["package", "library", "install", "variable", "graphics"]
    what: str = ""


#: The loader's message for a missing system library.
_LIBRARY = re.compile(r"(lib[\w.+-]+\.so[.\d]*): cannot open shared object file")
#: Name prefixes of Mesa's libraries.
_OF_GRAPHICS = ("libEGL", "libGL", "libOpenGL", "libOSMesa", "libvulkan")
#: Environment variables that select a driver or a library.
_VARIABLE = re.compile(r"\b(MUJOCO_GL|PYOPENGL_PLATFORM|VK_DRIVER_FILES|VK_ICD_FILENAMES|DRJIT_LIBLLVM_PATH)\b")


def recognised(error: BaseException) -> Cause | None:
    """Return the cause of an engine's failure if it has a known remedy; None for bugs and everything else."""
    chain = list(_chain(error))
    if any(map(is_own_error, chain)):
        return None
    for one in chain:
        if isinstance(one, ModuleNotFoundError) and one.name and "." not in one.name:
            return Cause("package", one.name)
    if any(isinstance(one, GraphicsError) for one in chain):
        return Cause("graphics")
    for one in chain:
        if isinstance(one, ImportError | OSError) and (library := _LIBRARY.search(str(one))):
            return Cause("library", library[1])
        if (variable := _VARIABLE.search(str(one))) and os.environ.get(variable[1]):
            return Cause("variable", variable[1])
        if isinstance(one, ImportError) and one.name:
            return Cause("install", one.name.split(".")[0])
    return None


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an exception and its causes."""
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def mending(cause: Cause, engine: Info, system: System) -> str:
    """Return the command that removes a cause, or an empty string if it does not concern the engine."""
    match cause.kind:
        case "variable":
            return f"unset {cause.what}"
        case "package":
            ours = cause.what == engine.module.split(".")[0]
            return engine_package(engine, system) if ours else pip(cause.what)
        case "install":
            ours = cause.what == engine.module.split(".")[0]
            return reinstalled(engine, system) if ours else ""
        case "library" if not cause.what.startswith(_OF_GRAPHICS):
            return f"install the package of your system that has {cause.what}"
    return drawing(engine, system)


def this_system() -> System:
    """Return the system of this machine."""
    try:
        release = platform.freedesktop_os_release()
    except OSError:
        release = {}
    ids = frozenset([release.get("ID", ""), *release.get("ID_LIKE", "").split()])
    return System(ids, release.get("VERSION_CODENAME", ""), os.geteuid() == 0)


def pip(requirement: str, *options: str) -> str:
    """Return the command that installs a requirement in this environment."""
    return " ".join([sys.executable, "-m pip install", *options, f"'{requirement}'"])


def engine_package(engine: Info, system: System) -> str:
    """Return the command that installs an engine; it compiles if there is no wheel for this Python."""
    build = engine.compiled
    if build is None or sys.version_info[:2] <= build.wheels_until:
        return pip(engine.requirement)
    compiler = f"{_apt(system)} g++ python3-dev" if system.ids & FAMILY else "install a C++ compiler"
    install = f"{build.variables} {pip(engine.requirement, '--no-build-isolation')}".strip()
    return " && ".join([compiler, *map(pip, build.needs), install])


def graphics(system: System, mesa: tuple[int, int]) -> str:
    """Return the command that installs software rendering, with at least that version of Mesa."""
    if not system.ids & FAMILY:
        oldest = ".".join(map(str, mesa))
        return f"install Mesa {oldest} or newer (EGL and the Vulkan driver lavapipe), or your GPU's driver"
    backports = DEBIAN_WITH_OLD_MESA.get(system.codename)
    if backports is None:
        return f"{_apt(system)} {PACKAGES}"
    # apt supplies the address of the system's own mirror.
    ask = f"apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Release: {system.codename}'"
    entry = f'echo "deb $({ask} | head -1) {backports} main"'
    add = f"{system.sudo}tee /etc/apt/sources.list.d/{backports}.list"
    return f"{entry} | {add} && {_apt(system)} -t {backports} {PACKAGES}"


def llvm(system: System, oldest: int) -> str:
    """Return the command that installs the compiler of the look "photo"."""
    return f"{_apt(system)} libllvm{oldest}" if system.ids & FAMILY else f"install LLVM {oldest} or newer"


def reinstalled(engine: Info, system: System) -> str:
    """Return the command that reinstalls an engine whose own modules cannot be imported."""
    return engine_package(engine, system).replace("pip install", "pip install --force-reinstall")


def drawing(engine: Info, system: System) -> str:
    """Return the command that installs the graphics libraries of an engine; empty if it needs none."""
    if engine.graphics is None:
        return ""
    if forced := _forced(engine.graphics):
        return f"unset {forced}"
    return graphics(system, engine.graphics.mesa)


def _forced(used: Graphics) -> str:
    """Return the environment variables that select another driver than the engine's default."""
    return " ".join(n for n in used.variables if os.environ.get(n, used.api).lower() != used.api.lower())


def _apt(system: System) -> str:
    return f"{system.sudo}apt-get update && {system.sudo}apt-get install"
