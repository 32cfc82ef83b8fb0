"""Files are read by one guarded reader: code that opens a path itself would wait for a pipe or fill the memory."""

from __future__ import annotations

import ast
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

import wmspec
from wmspec.core.limits import Limit
from wmspec.core.safe_io import NotARegularFile, load_image, open_file, read_bytes, read_text

PACKAGE = Path(wmspec.__file__).parent
#: Calls that open a path: methods of paths, and functions of libraries.
METHODS = {"read_text", "read_bytes"}
FUNCTIONS = {
    "np.load", "pq.read_table", "pq.ParquetFile", "Image.open", "trimesh.load", "sqlite3.connect", "zipfile.ZipFile",
}  # fmt: skip
#: What shows that a path was checked before, or that the data are in memory.
GUARDS = {"regular_file", "open_file", "BytesIO", "content"}
#: Modules that read files of wmspec itself, or that run without wmspec.
OWN = {
    "cli/__init__.py", "core/code_digest.py", "core/safe_io.py", "editor/start.py", "eval/export/folder.py",
    "eval/export/files/inspect_task.py", "eval/publish/files/answer.py", "eval/models/images.py", "eval/study/page.py",
    "lang/check/expressions/libraries.py", "lang/parse/pages.py", "lang/parse/tables.py", "dataset/build/webpage.py",
}  # fmt: skip
#: Calls whose path the lines before check.
CHECKED = {
    ("api/things.py", "trimesh.load"),
    ("compile/layout/meshes.py", "trimesh.load"),
    ("lang/importers/plausible.py", "trimesh.load"),
    ("lang/importers/mjcf_source.py", "trimesh.load"),
}


def calls(path: Path) -> Iterator[str]:
    """The calls of a module that open a path without a guard in the call."""
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.Call):
            continue
        name = ast.unparse(node.func)
        mode = node.args[0].value if node.args and isinstance(node.args[0], ast.Constant) else None
        opens = name == "open" or (name.endswith(".open") and str(mode).startswith("r"))
        reads = "." in name and name.rpartition(".")[2] in METHODS
        if opens or reads or name in FUNCTIONS:
            inner = " ".join(map(ast.unparse, [*node.args, *node.keywords]))
            if not any(guard in name + inner for guard in GUARDS):
                yield name


def test_files_are_opened_by_the_guarded_reader() -> None:
    found = {
        (path.relative_to(PACKAGE).as_posix(), call)
        for path in PACKAGE.rglob("*.py")
        for call in calls(path)
        if path.relative_to(PACKAGE).as_posix() not in OWN
    }
    assert found <= CHECKED


@pytest.mark.parametrize("read", [open_file, read_bytes, read_text, load_image])
def test_pipes_and_devices_are_refused(read: object, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert callable(read)
    for path in (tmp_path / "pipe", Path("/dev/zero"), Path("/dev/tty")):
        if path.exists():
            with pytest.raises(Exception, match="pipe or a device") as caught:
                read(path)
            assert isinstance(caught.value, NotARegularFile) or read is load_image


def test_a_file_above_its_limit_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "large").write_bytes(b"x" * 11)
    with pytest.raises(OSError, match="more than 10 bytes"):
        read_bytes(tmp_path / "large", Limit(10, "bytes"))
