"""Settings of all tests, and what each folder of them needs."""

from __future__ import annotations

import ctypes
import gc
import os
import tempfile
from importlib.util import find_spec
from itertools import chain
from pathlib import Path

# Before NumPy is imported. Several processes test at once, and the threads of each would wait for a core by computing:
# on two cores, products of small matrices took four times as long. `wmspec audit` and `report` have one thread, too.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("LP_NUM_THREADS", "0")  # of Mesa's software renderer, as in processes that generate datasets

import pytest
from hypothesis import settings

import wmspec
from tests.browser import browser
from tests.engines import ENGINES
from tests.shared import shared
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.engines.registry import default

__all__ = ["browser", "shared"]  # here alone: a process has one of each, however many folders use it

# Time limits belong in benchmarks: a loaded machine must not fail a law. In CI the same examples are tried every time.
settings.register_profile("wmspec", max_examples=50, deadline=None, derandomize=bool(os.environ.get("CI")))
settings.register_profile("long", settings.get_profile("wmspec"), max_examples=200)
settings.load_profile("wmspec")

# Datasets say when they were published: in tests, always on the same day.
os.environ.setdefault("SOURCE_DATE_EPOCH", "1767225600")

# What tests check is cached apart from what the user checks; workers of one run share it.
if "WMSPEC_CACHE_DIR" not in os.environ:
    _cache = tempfile.TemporaryDirectory(prefix="wmspec-cache-")
    os.environ["WMSPEC_CACHE_DIR"] = _cache.name

#: Memory (bytes) by which a process may grow before renderers are closed after a file; what was in use after the last.
GROWTH = 200_000_000
_kept_memory = 0

HERE = Path(__file__).parent
NEEDS = {
    "api": ("engine", "pixels"),
    "ask": ("engine",),
    "crosscheck": ("engine", "pixels"),
    "doctor": ("engine", "pixels"),
    "endtoend": ("engine", "pixels"),
    "films": ("engine", "pixels"),
    "package": ("build",),
    "physics": ("engine",),
    "pixels": ("engine", "pixels"),
    "recipes": ("build",),
    "thirdparty": ("engine",),
}
#: Files whose tests try many specs or cases, or execute long episodes: `make quick` leaves them out.
BROAD = {
    "language/test_beginners.py", "language/test_check_cache.py", "language/test_format.py", "language/test_machine.py",
    "language/test_mutants.py", "language/test_order.py", "language/test_overlapping_options.py",
    "language/test_plans.py", "language/test_robots.py", "language/test_robust.py", "physics/test_arms.py",
    "physics/test_determinism.py", "physics/test_left_out.py", "physics/test_native.py", "physics/test_oracles.py",
    "physics/test_own_arms.py", "physics/test_rollout.py", "physics/test_sharing.py", "stage/test_meshes.py",
    "stage/test_object_cache.py", "stage/test_parts.py",
}  # fmt: skip


def pytest_addoption(parser: pytest.Parser) -> None:
    reported = "Of the tests that run in one engine after another, those in the first that is installed."
    parser.addoption("--one-engine", action="store_true", help=reported)
    parser.addoption(
        "--installed", action="store_true", help="Fail unless the wmspec under test is an installed wheel."
    )


def pytest_configure(config: pytest.Config) -> None:
    if not config.getoption("--installed"):
        return
    package = Path(wmspec.__file__).parent
    # Without a safe path, what tests start in the root of the checkout imports the packages that lie there.
    if package == HERE.parent / "wmspec" or find_spec("backends") or not os.environ.get("PYTHONSAFEPATH"):
        raise pytest.UsageError(f"{package} is no installed wheel, or the checkout can be imported: use `make test`")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        if group := _sharing(item):
            item.add_marker(pytest.mark.xdist_group(group))
        if item.path.is_relative_to(HERE):
            for need in NEEDS.get(item.path.relative_to(HERE).parts[0], ()):
                item.add_marker(need)
            if item.path.relative_to(HERE).as_posix() in BROAD:
                item.add_marker("broad")
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker("browser")
    if config.getoption("--one-engine"):
        one = {default()}
        config.hook.pytest_deselected(items=[item for item in items if _engines(item) - one])
        items[:] = [item for item in items if not _engines(item) - one]


def pytest_collection_finish(session: pytest.Session) -> None:
    """Collect garbage as the command line does, and never look for it among the tests and what they import.

    Fail if this pytest-xdist does not group: every process would make all shared fixtures again, unnoticed.
    """
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    grouped = [item for item in session.items if item.get_closest_marker("xdist_group")]
    if getattr(session.config.option, "loadgroup", False) and not all("@" in item.nodeid for item in grouped):
        raise pytest.UsageError("pytest-xdist ignores groups with this version of pytest: install pytest<9.2")


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """After a file, close the renderers that are kept for further pictures, and give their memory back.

    They open again when they are needed. Otherwise a process that runs many files grows by gigabytes. A process that
    has hardly grown does not look for them: with all that tests import, that takes longer than many files.
    """
    global _kept_memory  # noqa: PLW0603  one session per process
    if nextitem is not None and nextitem.path == item.path:
        return
    memory = _resident_memory()
    if memory is None or memory > _kept_memory + GROWTH:
        for kept in gc.get_objects():
            if type(kept) is RenderCache:
                kept.close()
        gc.collect()
        if trim := getattr(ctypes.CDLL(None), "malloc_trim", None):  # of glibc
            trim(0)
        _kept_memory = _resident_memory() or 0


def _resident_memory() -> int | None:
    """The memory (bytes) of this process that is in RAM; None where the system does not say."""
    try:
        return int(Path("/proc/self/statm").read_bytes().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return None


def _sharing(item: pytest.Item) -> str:
    """The folder or file whose tests share a fixture of this one: a single process makes it (`--dist loadgroup`)."""
    known = getattr(item, "_fixtureinfo", None)
    fixtures = [each[-1] for each in known.name2fixturedefs.values()] if known else []
    places = {fixture.baseid for fixture in fixtures if fixture.scope in ("module", "session")}
    return min(places - {"", "tests"}, key=len, default="")


def _engines(item: pytest.Item) -> set[str]:
    """The engines that a test runs in as its parameters say: of a pair of them, both."""
    call = getattr(item, "callspec", None)
    values = [v if isinstance(v, tuple) else (v,) for v in (call.params.values() if call else ())]
    return {name for name in chain.from_iterable(values) if isinstance(name, str) and name in ENGINES}
