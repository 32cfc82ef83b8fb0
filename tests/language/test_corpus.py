"""The corpus: every `.wms` file under tests/corpus with its expected diagnostics, one per line.

To add a case, add a `.wms` file, run `UPDATE_CORPUS=1 pytest tests/language/test_corpus.py` and read what it wrote.
"""

import os
from pathlib import Path

import pytest

from wmspec.compile.lint.dry_run import dry_run
from wmspec.core.diagnostics import Report
from wmspec.core.places import Place, Span
from wmspec.lang.check.statements.task import check
from wmspec.lang.parse.codes import CODES

CORPUS = sorted((Path(__file__).parent.parent / "corpus").glob("*.wms"))


def diagnose(path: Path) -> str:
    report = Report()
    for spec in check(path, report):
        dry_run(spec, report)
    lines = []
    for d in report.diagnostics:
        assert d.code in CODES
        helped = f" | {d.help}" if d.help else ""
        lines.append(f"{d.severity} {d.code} {format_place(d.place, path)} {d.message}{helped}\n")
        lines += [f"    note {format_place(n.place, path)} {n.message}\n" for n in d.notes]
    return "".join(lines) or "no mistakes\n"


def format_place(span: Place | None, path: Path) -> str:
    """The position in the case's own text, or the name of the library, whose lines may move."""
    assert isinstance(span, Span)
    return f"{span.line}:{span.column}" if span.source.name == str(path) else f"in {Path(span.source.name).name}"


@pytest.mark.parametrize("path", CORPUS, ids=lambda p: p.stem)
def test_corpus(path: Path) -> None:
    expected = path.with_suffix(".expected")
    found = diagnose(path).replace(str(path), path.name)
    if os.environ.get("UPDATE_CORPUS"):
        expected.write_text(found)
    assert found == expected.read_text()


def test_every_code_but_a_few_is_in_the_corpus() -> None:
    """Every code needs a case in the corpus."""
    shown = {word for p in CORPUS for word in p.with_suffix(".expected").read_text().split() if word.startswith("WMS")}
    assert set(CODES) - shown <= {"WMS208"}
