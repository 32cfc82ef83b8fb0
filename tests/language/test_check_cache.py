"""Cached results about specs equal those of a fresh process, and are never older than their dependencies."""

import json
import os
import pickle
import shutil
import subprocess
import sys
import zlib
from base64 import b64encode
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.examples import slow_except
from wmspec.api import load_all
from wmspec.api.checking import Checked, check_files
from wmspec.api.generating import spec_texts
from wmspec.api.spec_cache import LISTING, Cached, Entry
from wmspec.core import disk_cache, node_pickle
from wmspec.core.diagnostics import Report, WmsError
from wmspec.core.node import Node
from wmspec.core.places import Source
from wmspec.lang.check.ir import ir
from wmspec.lang.parse import library_cache
from wmspec.lang.parse.files import library_folder, read_source
from wmspec.lang.parse.parser import parse

ROOT = Path(__file__).parents[2]
CORPUS = sorted((ROOT / "tests/corpus").glob("*.wms"))
LIBRARIES = sorted(library_folder().glob("*.wms"))
CATALOGUE = [ROOT / f"specs/{name}.wms" for name in ("prediction/mechanistic/collide", "prediction/mechanistic/topple")]
SPEC = "use mine\ntask t : custom {{ object o {{ shape: sphere  mass: {} kg  on: mat }}  observe front at [0 s] }}\n"
LIBRARY = "use tabletop\nobject mat {{ shape: box  size: ({} cm, 4 cm, 1 cm)  on: table }}\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A separate cache for the test."""
    monkeypatch.setenv("WMSPEC_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def hits(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether each search in the cache was a hit."""
    seen: list[bool] = []

    def watched(
        self: Entry, decode: object, real: Callable[..., Cached[object] | None] = Entry.read
    ) -> Cached[object] | None:
        found = real(self, decode)
        seen.append(found is not None)
        return found

    monkeypatch.setattr(Entry, "read", watched)
    return seen


def seen(checked: Checked) -> object:
    """The complete output for users."""
    return [d.render() for d in checked.diagnostics], [d.record() for d in checked.diagnostics], checked.tasks


@pytest.mark.parametrize("path", [*slow_except(CORPUS[::4], CORPUS), *CATALOGUE], ids=lambda path: path.stem)
def test_a_cached_result_is_the_result(path: Path, hits: list[bool]) -> None:
    with disk_cache.disabled():
        plain = check_files([path])
    first, again = check_files([path]), check_files([path])
    assert plain == first == again
    assert seen(plain) == seen(first) == seen(again)
    listing = LISTING & {d.code for d in plain.diagnostics}
    assert hits == [False, False, not listing]


@pytest.mark.parametrize("path", CATALOGUE, ids=lambda path: path.stem)
def test_tasks_from_the_cache_are_the_tasks(path: Path, hits: list[bool]) -> None:
    with disk_cache.disabled():
        fresh = load_all(path, seed=3)
    _, cached = load_all(path, seed=3), load_all(path, seed=3)
    assert cached == fresh
    assert spec_texts(cached) == spec_texts(fresh)
    assert hits == [False, False, True]


def test_a_check_caches_the_tasks(hits: list[bool]) -> None:
    with disk_cache.disabled():
        fresh = load_all(CATALOGUE[0])
    check_files(CATALOGUE)
    hits.clear()
    assert load_all(CATALOGUE[0]) == fresh
    assert hits == [True]


def test_warnings_come_from_the_cache_too(tmp_path: Path, hits: list[bool]) -> None:
    spec = tmp_path / "spec.wms"
    spec.write_text("use tabletop\ntask t : custom { let unused = 1  observe front at [0 s] }\n")
    warned: list[list[str]] = [[], []]
    for texts in warned:
        load_all(spec, tell=texts.append)
    assert warned[0] == warned[1]
    assert "`unused` is never used" in warned[0][0]
    assert hits == [False, True]


def test_every_dependency_changes_the_result(tmp_path: Path, hits: list[bool], monkeypatch: pytest.MonkeyPatch) -> None:
    spec, foreign = tmp_path / "spec.wms", tmp_path / "elsewhere"
    foreign.mkdir()
    monkeypatch.setenv("WMSPEC_PATH", str(foreign))
    changes: list[Callable[[], object]] = [
        lambda: spec.write_text(SPEC.format(1)),
        lambda: (foreign / "mine.wms").write_text(LIBRARY.format(4)),
        lambda: spec.write_text(SPEC.format(-1)),
        lambda: (foreign / "mine.wms").write_text(LIBRARY.format(-4)),
        lambda: (tmp_path / "mine.wms").write_text(LIBRARY.format(5)),  # found before the other
        lambda: (tmp_path / "tabletop.wms").write_text("object table { size: 1 kg }\n"),
        (tmp_path / "tabletop.wms").unlink,
        (tmp_path / "mine.wms").unlink,
        (foreign / "mine.wms").unlink,
    ]
    for change in changes:
        change()
        hits.clear()
        with disk_cache.disabled():
            plain, task = check_files([spec]), loaded(spec)
        for _ in range(2):
            assert seen(check_files([spec])) == seen(plain)
            assert loaded(spec) == task
        assert hits[:3] == [False] * 3, "an old result was returned"


def loaded(spec: Path) -> object:
    """The tasks of a spec, or what is wrong with it."""
    try:
        return load_all(spec)
    except WmsError as error:
        return str(error)


def test_other_files_that_a_spec_names_count(tmp_path: Path, hits: list[bool]) -> None:
    mesh, spec = tmp_path / "specs/cube.obj", tmp_path / "specs/spec.wms"
    mesh.parent.mkdir()
    mesh.write_text(CUBE)
    spec.write_text(
        "use tabletop\n"
        'task t : custom { object o { file: "cube.obj"  scale: 0.1  on: table }  observe front at [0 s] }\n'
    )
    first = check_files([spec])
    assert first.passed
    assert check_files([spec]) == first
    mesh.write_text(CUBE.replace("v 0 0 0\n", "v nothing\n"))
    changed = check_files([spec])
    assert not changed.passed
    assert hits == [False, True, False]


CUBE = """v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 1 4 3 2
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "link", "open to others", "folder open to others"])
def test_an_entry_that_cannot_be_trusted_is_ignored(damage: str, folder: Path, hits: list[bool]) -> None:
    path = ROOT / "tests/corpus/three_mistakes.wms"
    plain = check_files([path])
    for entry in folder.iterdir():
        content = entry.read_bytes()
        if damage == "cut":
            entry.write_bytes(content[: len(content) // 2])
        elif damage == "flipped":
            entry.write_bytes(content[:-9] + bytes([content[-9] ^ 1]) + content[-8:])
        elif damage == "empty":
            entry.write_bytes(b"")
        elif damage == "link":
            entry.rename(folder.parent / entry.name)
            entry.symlink_to(folder.parent / entry.name)
        elif damage == "open to others":
            entry.chmod(0o666)
    if damage == "folder open to others":
        folder.chmod(0o777)
    assert check_files([path]) == plain
    assert hits == [False, False]


def test_foreign_entry_is_ignored(folder: Path, hits: list[bool]) -> None:
    """Its checksum is right, but this version has another format."""
    path = ROOT / "tests/corpus/three_mistakes.wms"
    plain = check_files([path])
    (entry,) = folder.glob("check-*")
    record = json.loads(zlib.decompress(disk_cache.read(entry.name) or b""))
    wrong: object
    for wrong in ({}, [], record | {"diagnostics": [1]}, record | {"uses": 3}, record | {"value": [[]]}):
        disk_cache.write(entry.name, zlib.compress(json.dumps(wrong).encode()))
        assert check_files([path]) == plain
    disk_cache.write(entry.name, json.dumps(record).encode())
    assert check_files([path]) == plain
    assert hits == [False] * 7


def test_a_cache_that_cannot_be_written_costs_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("WMSPEC_CACHE_DIR", str(tmp_path / "file" / "below"))
    assert not check_files([ROOT / "tests/corpus/three_mistakes.wms"]).passed


@pytest.mark.parametrize("path", slow_except(LIBRARIES[::4], LIBRARIES), ids=lambda path: path.stem)
def test_a_library_from_the_cache_is_the_library(path: Path) -> None:
    source = read_source(path)
    tree = parse(source, Report())
    library_cache.store(source, tree)
    cached = library_cache.load_cached(source)
    assert cached == tree
    assert cached.span.source is source
    assert library_cache.load_cached(Source(source.name, source.text + "\n")) is None


class _Forged:
    def __reduce__(self) -> tuple[object, ...]:
        return os.mkdir, ("forged",)


FORGED = pytest.mark.parametrize("forged", [_Forged(), Path("x"), ("no tree",)], ids=["call", "class", "other"])


@FORGED
def test_forged_tasks_execute_nothing(
    forged: object, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (task,) = load_all(CATALOGUE[0])
    (entry,) = folder.glob("spec-*")
    record = json.loads(zlib.decompress(disk_cache.read(entry.name) or b""))
    record["value"] = b64encode(pickle.dumps(forged)).decode()
    disk_cache.write(entry.name, zlib.compress(json.dumps(record).encode()))
    assert load_all(CATALOGUE[0]) == (task,)
    assert not (tmp_path / "forged").exists()


def test_a_pickle_of_nodes_holds_nodes_of_one_module_alone() -> None:
    tree = parse(Source("x.wms", "object o { }\n"), Report())
    assert isinstance(tree, Node)
    with pytest.raises(ValueError, match="is no node"):
        node_pickle.loads(node_pickle.dumps(tree), ir, Source("x.wms", ""))


@FORGED
def test_a_forged_library_executes_nothing(forged: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    source = Source("x.wms", "object o { }\n")
    disk_cache.write(library_cache._entry(source), pickle.dumps(forged))
    assert library_cache.load_cached(source) is None
    assert not (tmp_path / "forged").exists()


def test_old_entries_make_room(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disk_cache, "MAX_ENTRIES", 8)
    for i in range(30):
        disk_cache.write(f"entry-{i}", b"x")
    assert 4 <= len(list(folder.iterdir())) <= 8
    assert disk_cache.read("entry-29") == b"x"


def test_a_cached_check_imports_nothing_of_the_checker(tmp_path: Path) -> None:
    """Each of these takes longer to import than the whole check may take."""
    spec = tmp_path / "spec.wms"
    shutil.copy(ROOT / "specs/prediction/mechanistic/topple.wms", spec)
    for _ in range(2):
        command = [sys.executable, "-X", "importtime", "-m", "wmspec", "check", str(spec)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "wmspec.api.checking" in imported
    assert not imported & {
        "numpy",
        "lark",
        "wmspec.lang.parse.syntax",
        "wmspec.lang.parse.parser",
        "wmspec.lang.check",
        "wmspec.compile.design",
    }
