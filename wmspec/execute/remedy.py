"""The commands that mend a machine: Python packages by pip, graphics libraries by the system's own packages."""

from __future__ import annotations

import os
import platform
import sys
from dataclasses import dataclass

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


def engine_package(engine: str, system: System) -> str:
    """The command that installs an engine. PyBullet has wheels up to Python 3.11 and is compiled on newer ones;

    NumPy must be in sight then, or its pictures come back as tuples, and GCC 14 takes its pointers for errors.
    """
    if engine != "pybullet" or sys.version_info < (3, 12):
        return pip(f"wmspec[{engine}]")
    compiler = f"{_apt(system)} g++ python3-dev" if system.ids & FAMILY else "install a C++ compiler"
    build = f"CFLAGS=-Wno-incompatible-pointer-types {pip('wmspec[pybullet]', '--no-build-isolation')}"
    return f"{compiler} && {pip('setuptools>=70.1')} && {build}"


def graphics(system: System) -> str:
    """The command that installs what engines draw with when there is no GPU, in a version that is new enough."""
    if not system.ids & FAMILY:
        return "install Mesa 24.3 or newer (EGL and the Vulkan driver lavapipe), or your GPU's driver"
    backports = DEBIAN_WITH_OLD_MESA.get(system.codename)
    if backports is None:
        return f"{_apt(system)} {PACKAGES}"
    # The address is asked of apt: the one that the system has for itself.
    ask = f"apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Release: {system.codename}'"
    entry = f'echo "deb $({ask} | head -1) {backports} main"'
    add = f"{system.sudo}tee /etc/apt/sources.list.d/{backports}.list"
    return f"{entry} | {add} && {_apt(system)} -t {backports} {PACKAGES}"


def executing(engine: str, system: System) -> str:
    """The command that lets an installed engine execute."""
    if engine == "mujoco" and (forced := _forced(engine)):  # it cannot even be imported with a name it doesn't know
        return f"unset {forced}"
    return engine_package(engine, system).replace("pip install", "pip install --force-reinstall")


def drawing(engine: str, system: System) -> str:
    """The command that lets an installed engine draw."""
    if forced := _forced(engine):
        return f"unset {forced}"
    if engine == "pybullet":  # it draws by itself, so it was built badly
        return executing(engine, system)
    return graphics(system)


def _forced(engine: str) -> str:
    """The environment variables that choose another driver than the engine would."""
    choices = {"mujoco": ("MUJOCO_GL", "PYOPENGL_PLATFORM"), "sapien": ("VK_DRIVER_FILES", "VK_ICD_FILENAMES")}
    return " ".join(n for n in choices.get(engine, ()) if os.environ.get(n, "egl") != "egl")


def _apt(system: System) -> str:
    return f"{system.sudo}apt-get update && {system.sudo}apt-get install"
