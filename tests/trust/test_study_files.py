"""Untrusted studies: databases with programs or values of no server, odd study files, links that lead out."""

from __future__ import annotations

import sqlite3
import threading
from contextlib import closing
from pathlib import Path

import pytest

from benchmarks.spoiled_files import PROGRAMS
from tests.study.conftest import dataset, study  # noqa: F401  fixtures
from tests.study.visitor import get
from wmspec.core.diagnostics import WmsError
from wmspec.eval.study import store
from wmspec.eval.study.answers import Person
from wmspec.eval.study.model import Study, load
from wmspec.eval.study.serve import StudyServer
from wmspec.eval.study.store import AnswerStore


@pytest.fixture
def answered(study: Path) -> Path:  # noqa: F811
    """The study, with one visit."""
    opened = AnswerStore(study / store.ANSWERS_FILE, load(study))
    opened.begin(Person(session="0" * 32, rater="anne"))
    opened.close()
    return study


def changed(folder: Path, statements: str) -> Study:
    with closing(sqlite3.connect(folder / store.ANSWERS_FILE, isolation_level=None)) as file:
        file.executescript(statements)
    return load(folder)


@pytest.mark.parametrize("program", [*PROGRAMS[:7], PROGRAMS[8]], ids=range(8))
def test_a_database_with_programs(answered: Path, program: str) -> None:
    made = changed(answered, program)
    with pytest.raises(WmsError, match="it has the program"):
        AnswerStore(answered / store.ANSWERS_FILE, made)


@pytest.mark.parametrize("values", ["slot = 99", "slot = -1", "slot = 'x'", "code = x'ff'", "rater = x'ff'"])
def test_a_database_with_values_of_no_server(answered: Path, values: str) -> None:
    made = changed(
        answered,
        "create table copy as select * from visit; drop table visit; alter table copy rename to visit;"
        f"update visit set {values}",
    )
    with pytest.raises(WmsError, match="its table `visit` has values of no server"):
        AnswerStore(answered / store.ANSWERS_FILE, made)


def test_a_picture_that_is_a_link_is_not_served(study: Path, tmp_path: Path) -> None:  # noqa: F811
    (tmp_path / "secret.png").write_bytes(b"secret")
    picture = sorted((study / "page/pictures").iterdir())[0]
    picture.unlink()
    picture.symlink_to(tmp_path / "secret.png")
    with StudyServer(study, "127.0.0.1", 0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        status, content = get(server.server_address[1], f"/pictures/{picture.name}")
        server.shutdown()
        thread.join()
    assert status == 404
    assert b"secret" not in content
