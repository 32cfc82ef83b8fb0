"""The commands that mend a machine: Python packages by pip, graphics libraries by the system's own packages."""

from __future__ import annotations

import os
import platform
import sys
from dataclasses import dataclass

from wmspec.sim.scene.backend import Graphics, Info

PACKAGES = "mesa-vulkan-drivers libegl-mesa0 libgl1-mesa-dri libegl1 libgl1 libvulkan1"
DEBIAN_WITH_OLD_MESA = {"bookworm": "bookworm-backports"}  # Debian 12: Mesa 22.3, and 25.0 in its backports
FAMILY = {"debian", "ubuntu"}


@dataclass(frozen=True)
class System:
    """What decides how packages are installed: the names in os-release, and whether we are root."""

    ids: frozenset[str]
    codename: str
    root: bool

    @property
    def sudo(self) -> str:
        """What a command begins with."""
        return "" if self.root else "sudo "


def this_system() -> System:
    """The system we run on."""
    try:
        release = platform.freedesktop_os_release()
    except OSError:
        release = {}
    ids = frozenset([release.get("ID", ""), *release.get("ID_LIKE", "").split()])
    return System(ids, release.get("VERSION_CODENAME", ""), os.geteuid() == 0)


def pip(requirement: str, *options: str) -> str:
    """The command that installs a requirement where we run."""
    return " ".join([sys.executable, "-m pip install", *options, f"'{requirement}'"])


def engine_package(engine: Info, system: System) -> str:
    """The command that installs an engine; it compiles it where there is no wheel for this Python."""
    build = engine.compiled
    if build is None or sys.version_info[:2] <= build.wheels_until:
        return pip(engine.requirement)
    compiler = f"{_apt(system)} g++ python3-dev" if system.ids & FAMILY else "install a C++ compiler"
    install = f"{build.variables} {pip(engine.requirement, '--no-build-isolation')}".strip()
    return " && ".join([compiler, *map(pip, build.needs), install])


def graphics(system: System, mesa: tuple[int, int]) -> str:
    """The command that installs what engines draw with when there is no GPU; at least that version of Mesa."""
    if not system.ids & FAMILY:
        oldest = ".".join(map(str, mesa))
        return f"install Mesa {oldest} or newer (EGL and the Vulkan driver lavapipe), or your GPU's driver"
    backports = DEBIAN_WITH_OLD_MESA.get(system.codename)
    if backports is None:
        return f"{_apt(system)} {PACKAGES}"
    # The address is asked of apt: the one that the system has for itself.
    ask = f"apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Release: {system.codename}'"
    entry = f'echo "deb $({ask} | head -1) {backports} main"'
    add = f"{system.sudo}tee /etc/apt/sources.list.d/{backports}.list"
    return f"{entry} | {add} && {_apt(system)} -t {backports} {PACKAGES}"


def llvm(system: System, oldest: int) -> str:
    """The command that installs what compiles the look "photo"."""
    return f"{_apt(system)} libllvm{oldest}" if system.ids & FAMILY else f"install LLVM {oldest} or newer"


def executing(engine: Info, system: System) -> str:
    """The command that lets an installed engine execute."""
    if engine.graphics and engine.graphics.on_import and (forced := _forced(engine.graphics)):
        return f"unset {forced}"
    return engine_package(engine, system).replace("pip install", "pip install --force-reinstall")


def drawing(engine: Info, system: System) -> str:
    """The command that lets an installed engine draw."""
    if engine.graphics is None:  # it draws by itself, so it was built badly
        return executing(engine, system)
    if forced := _forced(engine.graphics):
        return f"unset {forced}"
    return graphics(system, engine.graphics.mesa)


def _forced(used: Graphics) -> str:
    """The environment variables that choose another driver than the engine would."""
    return " ".join(n for n in used.variables if os.environ.get(n, used.api).lower() != used.api.lower())


def _apt(system: System) -> str:
    return f"{system.sudo}apt-get update && {system.sudo}apt-get install"
