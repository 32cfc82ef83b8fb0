"""Untrusted results and journals: impossible contents are reported, and no name is a command of LaTeX."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.dataset.made import make, plan
from tests.trust.made import wmspec
from wmspec.core.diagnostics import WmsError
from wmspec.eval.models import results
from wmspec.eval.models.journal import Journal

if TYPE_CHECKING:
    import pandas as pd

pytest.importorskip("pandas")


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dataset") / "in"
    make(folder, plan(), size=24)
    return folder


@pytest.fixture(scope="module")
def original(dataset: Path) -> Path:
    path = dataset.parent / "r.parquet"
    assert wmspec("evaluate", dataset, "-m", "random", "-o", path).exit_code == 0
    return path


def rewritten(original: Path, path: Path, **values: Any) -> Path:
    rows, about = results.read(original)
    rows[1] |= values
    results.write(path, rows, about)
    return path


@pytest.mark.parametrize(
    ("values", "reported"),
    [
        ({"task": "../../x"}, "`task` is '../../x', which is not a name"),
        ({"task": None}, "row 2: `task` is null"),
        ({"id": None}, "row 2: `id` is null"),
        ({"model": "\x1b]0;x\x07"}, r"`model` is '\x1b]0;x\x07', which is not a name"),
        ({"model": None}, "row 2: `model` is null"),
        ({"right": None}, "row 2: `right` is null"),
        ({"status": "well"}, "a status is 'well'"),
        ({"parsed": 99}, "row 2: it is of other options than its `order`"),
        ({"order": [7, 7]}, "row 2: it is of other options than its `order`"),
        ({"order": [None, 0]}, "row 2: it is of other options than its `order`"),
    ],
)
def test_rows_that_no_run_writes(
    tmp_path: Path, dataset: Path, original: Path, values: dict[str, Any], reported: str
) -> None:
    path = rewritten(original, tmp_path / "evil.parquet", **values)
    content = path.read_bytes()
    for command in (
        ["report", path, "-o", tmp_path / "report"],
        ["view", dataset, "--results", path, "-o", tmp_path / "page.html"],
        ["evaluate", "--rescore", path],
    ):
        result = wmspec(*command)
        assert result.exit_code == 2
        assert "evil.parquet: no results of wmspec" in result.output
        assert reported in result.output
    assert path.read_bytes() == content


def test_columns_of_another_type(tmp_path: Path, original: Path) -> None:
    table = pq.read_table(original)
    place = table.column_names.index("order")
    pq.write_table(table.set_column(place, "order", pa.array(["x"] * len(table))), tmp_path / "evil.parquet")
    result = wmspec("report", tmp_path / "evil.parquet", "-o", tmp_path / "report")
    assert result.exit_code == 2
    assert "evil.parquet: no results of wmspec" in result.output


def test_a_models_name_is_no_command(tmp_path: Path) -> None:
    pd = pytest.importorskip("pandas")
    from wmspec.eval.report.latex import latex_table

    name = r"a\input{/etc/passwd}$x^2$~"
    written = latex_table("caption", pd.DataFrame({"x": ["1"]}, index=[name]))
    assert r"a\textbackslash{}input\{/etc/passwd\}\$x\textasciicircum{}2\$\textasciitilde{}" in written


@pytest.mark.parametrize(
    "line", [b"[" * 100_000, b'{"id": 1}', b'{"id": "a", "permutation": 0, "sample": 0, "text": 5}']
)
def test_invalid_journal_is_an_error(tmp_path: Path, line: bytes) -> None:
    path = tmp_path / "r.journal.jsonl"
    path.write_bytes(b'{"asked": {}}\n' + line + b"\n")
    with pytest.raises(WmsError, match="no journal of this version"):
        Journal(path, {})
    assert path.read_bytes().endswith(line + b"\n")


@pytest.mark.parametrize(
    ("values", "reported"),
    [
        ({"text": None}, "row 2: `text` is null"),
        ({"options": ["a"]}, "row 2: it is of other options than its `order`"),
        ({"options": None}, "row 2: `options` is null"),
    ],
)
def test_texts_that_no_run_writes(tmp_path: Path, original: Path, values: dict[str, Any], reported: str) -> None:
    result = wmspec("evaluate", "--rescore", rewritten(original, tmp_path / "evil.parquet", **values))
    assert result.exit_code == 2
    assert reported in result.output


def of_models(original: Path, path: Path, count: int) -> Path:
    rows, about = results.read(original)
    results.write(path, [{**row, "model": f"m{n}"} for n in range(count) for row in rows], about)
    return path


def test_a_report_of_many_models(tmp_path: Path, original: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """780 pairs of systems with the same questions share what does not depend on the replies."""
    from wmspec.eval.report import compare
    from wmspec.eval.report.replies import read

    whole, calls = compare.weights_in_average, list[int]()

    def counted(questions: pd.DataFrame) -> Any:
        calls.append(len(questions))
        return whole(questions)

    monkeypatch.setattr(compare, "weights_in_average", counted)
    found = compare.comparisons(read([of_models(original, tmp_path / "many.parquet", 40)], None))
    assert len(found) == 780 * len({each.kind for each in found})
    assert len(calls) == len({each.kind for each in found})


def test_a_report_of_too_many_models(tmp_path: Path, original: Path) -> None:
    from wmspec.eval.report.replies import read

    with pytest.raises(WmsError, match="the results are of 301 systems, and a report compares at most 300"):
        read([of_models(original, tmp_path / "many.parquet", 301)], None)
