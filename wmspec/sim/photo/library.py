"""Mitsuba itself: imported when it is first used, in the variant that this machine's variables ask for.

It interprets every path (`scalar_rgb`), which needs nothing and gives the same bytes everywhere; or, where the variable
of its own that names LLVM is set, it compiles them (`llvm_ad_rgb`), which takes less time and rounds otherwise.
"""

from __future__ import annotations

import ctypes
import os
import re
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.native_output import silence

REQUIREMENT = "wmspec[photo]"
DISTRIBUTIONS = ("mitsuba", "mitsuba-oidn")
LLVM = "DRJIT_LIBLLVM_PATH"
"""Mitsuba's own variable: the path of libLLVM."""

_NAME = re.compile(r"libLLVM(?:-|\.so\.)(\d+)[\d.]*(?:\.so)?(?:\.[\d.]+)?")
OLDEST_LLVM = 19
"""Measured: with 14 and 15 Mitsuba 3.9 ends the process."""


def variant() -> str:
    """How Mitsuba computes here. Raises WmsError if the LLVM that is asked for will not do."""
    path = os.environ.get(LLVM, "")
    if not path:
        return "scalar_rgb"
    if not llvm_version(path) >= OLDEST_LLVM:
        raise WmsError(
            f"{LLVM} names `{path}`, which is no LLVM {OLDEST_LLVM} or newer",
            help=f"unset {LLVM}: pictures then take longer; or see `wmspec doctor`",
        )
    return "llvm_ad_rgb"


def llvm_version(path: str) -> int:
    """The major version of a libLLVM; 0 if there is none, or one from before 16, which could not be asked."""
    major = ctypes.c_uint(0)
    try:
        ctypes.CDLL(path).LLVMGetVersion(ctypes.byref(major), None, None)
    except (OSError, AttributeError):
        return 0
    return major.value


def newest_llvm() -> str:
    """The newest LLVM where systems keep their libraries, if it is new enough; by its name, without loading it."""
    found = [(int(name[1]), str(path)) for path in _libraries() if (name := _NAME.fullmatch(path.name))]
    return max((path for path in found if path[0] >= OLDEST_LLVM), default=(0, ""))[1]


def _libraries() -> Iterator[Path]:
    for folder in ("lib", "lib64", "local/lib"):
        for pattern in ("libLLVM*", "*/libLLVM*", "*/lib/libLLVM*"):
            yield from sorted(Path("/usr", folder).glob(pattern))


def mitsuba() -> Any:
    """Mitsuba, in the right variant. Raises WmsError if it, or its denoiser, is not installed."""
    chosen = variant()
    try:
        with silence():
            import mitsuba
            import mitsuba_oidn  # noqa: F401
    except ImportError as error:
        raise WmsError(
            f"the look `photo` is drawn by Mitsuba, which cannot be imported ({error})",
            help=f"install it with `pip install '{REQUIREMENT}'`",
        ) from None
    if mitsuba.variant() != chosen:
        mitsuba.set_variant(chosen)
        mitsuba.set_log_level(mitsuba.LogLevel.Error)
    return mitsuba


def versions() -> dict[str, str]:
    """What decides the bytes of its pictures. Raises WmsError if it is not installed."""
    mitsuba()
    found = {name: version(name) for name in DISTRIBUTIONS}
    return found | {"mitsuba": f"{found['mitsuba']} {variant()}"}
