"""Imports work when installed, and importing wmspec changes nothing that others in the process share."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import wmspec
import wmspec.backends
from tests.engines import ENGINES
from wmspec.runtime.engines.registry import info

ROOT = Path(__file__).parents[2]

STATE = """
import atexit, gc, importlib, locale, os, pkgutil, signal, sys

# What these do as they are imported is theirs.
import click, lark, multiprocessing.util, numpy, PIL.Image, pebble, pyarrow, pydantic
import rich.progress, scipy, sklearn, trimesh
from concurrent.futures import ProcessPoolExecutor
from pxr import Usd
for engine in {modules}: importlib.import_module(engine)

def state():
    signals = [signal.getsignal(s) for s in signal.valid_signals()]
    limits = sys.getrecursionlimit(), gc.get_threshold(), gc.isenabled(), sys.excepthook
    return dict(os.environ), os.getcwd(), sys.path[:], signals, limits, locale.setlocale(locale.LC_ALL), numpy.geterr()

ours = []
register = atexit.register
atexit.register = lambda f, *a, **k: (ours.append(f) if f.__module__.startswith("wmspec") else None, register(f))[1]
before = state()
import wmspec, wmspec.backends
folders = [(wmspec.__path__[:1], "wmspec.")]
folders += [([f"{{wmspec.backends.__path__[0]}}/{{name}}"], f"wmspec.backends.{{name}}.") for name in {names}]
for folder, prefix in folders:
    for module in pkgutil.walk_packages(folder, prefix):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
after = state()
print([pair for pair in zip(before, after) if pair[0] != pair[1]] + ours)
"""


def test_importing_all_of_it_changes_nothing_shared() -> None:
    names = [name for name in ENGINES if find_spec(info(name).module)]
    code = STATE.format(modules=[info(name).module for name in names], names=names)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip().endswith("[]")


def test_backends_are_imported_by_the_name_that_they_have_when_installed() -> None:
    """Only a checkout has `backends`. Inside it siblings are imported with a dot, elsewhere from `wmspec.backends`."""
    absolute = re.compile(r"^\s*(?:from|import) backends\b.*", re.MULTILINE)
    folders = ("wmspec", "backends", "tests", "tools", "benchmarks", "conformance", "docs")
    files = [path for folder in folders for kind in ("*.py", "*.md") for path in (ROOT / folder).rglob(kind)]
    assert not {str(path): found for path in files if (found := absolute.findall(path.read_text("utf-8")))}


def test_subprocesses_of_tests_import_the_same_wmspec() -> None:
    code = "import wmspec.backends; print(wmspec.__file__, wmspec.backends.__file__)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [wmspec.__file__, wmspec.backends.__file__]
