"""Mitsuba, imported on first use in the variant that environment variables select.

`scalar_rgb` interprets every path, has no further dependencies and gives equal bytes everywhere. With Mitsuba's
variable for LLVM set, `llvm_ad_rgb` compiles paths: faster, with different rounding.
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
"""Mitsuba's environment variable with the path of libLLVM."""

_NAME = re.compile(r"libLLVM(?:-|\.so\.)(\d+)[\d.]*(?:\.so)?(?:\.[\d.]+)?")
OLDEST_LLVM = 19
"""With LLVM 14 and 15, Mitsuba 3.9 aborts the process."""


def variant() -> str:
    """Return the Mitsuba variant. Raises WmsError if the requested LLVM is unsuitable."""
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
    """Return the major version of a libLLVM; 0 if it is missing or older than 16."""
    major = ctypes.c_uint(0)
    try:
        ctypes.CDLL(path).LLVMGetVersion(ctypes.byref(major), None, None)
    except (OSError, AttributeError):
        return 0
    return major.value


def newest_llvm() -> str:
    """Return the newest suitable LLVM of the system by file name, without loading it."""
    found = [(int(name[1]), str(path)) for path in _libraries() if (name := _NAME.fullmatch(path.name))]
    return max((path for path in found if path[0] >= OLDEST_LLVM), default=(0, ""))[1]


def _libraries() -> Iterator[Path]:
    for folder in ("lib", "lib64", "local/lib"):
        for pattern in ("libLLVM*", "*/libLLVM*", "*/lib/libLLVM*"):
            yield from sorted(Path("/usr", folder).glob(pattern))


def mitsuba() -> Any:
    """Return Mitsuba in the right variant. Raises WmsError if it or its denoiser is missing."""
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
    """Return the versions that determine the bytes of pictures. Raises WmsError if Mitsuba is missing."""
    mitsuba()
    found = {name: version(name) for name in DISTRIBUTIONS}
    return found | {"mitsuba": f"{found['mitsuba']} {variant()}"}
