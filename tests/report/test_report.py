"""The report as a user makes it: the command, its files, its page in a real browser, and what it says to bad input."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner, Result

from tests.browser import barriers, opened
from tests.report.conftest import Made
from tests.report.made import Rater, answers, write
from wmspec.cli import main
from wmspec.eval.report.report import report
from wmspec.eval.report.write import write as write_report

#: The name of a model that would write into the page.
EVIL = "<script>alert(1)</script>"


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["report", *map(str, arguments)])


@pytest.fixture(scope="session")
def folder(made: Made, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("report")
    write_report(made.report, place)
    return place


@dataclass(frozen=True)
class Ran:
    """A run of the command: the results, the folder it wrote, and what it said."""

    table: pd.DataFrame
    out: Path
    output: str


@pytest.fixture(scope="module")
def ran(made: Made, tmp_path_factory: pytest.TempPathFactory) -> Ran:
    place = tmp_path_factory.mktemp("ran")
    raters = (Rater("a", lambda row: 0.8), Rater(EVIL, lambda row: 0.4, permutations=2))
    table = answers(made.rows[::9], *raters)
    results = write(place / "results" / "few.parquet", table)
    done = run(results.parent, "--dataset", made.folder, "-o", place / "out")
    assert done.exit_code == 0, done.output
    return Ran(table, place / "out", done.output)


def test_the_command_writes_everything(ran: Ran) -> None:
    assert "Perception: a is right most often, in " in ran.output
    there = {str(p.relative_to(ran.out)) for p in ran.out.rglob("*") if p.is_file()}
    assert {
        "report.html",
        "report.json",
        "figures/averages.svg",
        "tables/perception.csv",
        "tables/perception.tex",
    } <= there
    said = json.loads((ran.out / "report.json").read_text())
    assert {line["system"] for table in said["tables"] for line in table["lines"]} == {"a", EVIL}


def test_without_the_dataset_independent_figures_are_reported(made: Made, tmp_path: Path) -> None:
    results = write(tmp_path / "few.parquet", answers(made.rows[::9], Rater("a", lambda row: 0.8)))
    done = run(results, "-o", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert "Without --dataset" in done.output
    assert not (tmp_path / "out" / "tables" / "entanglement.csv").exists()


@pytest.mark.slow
def test_every_table_and_figure_has_the_same_bytes_again(made: Made, folder: Path, tmp_path: Path) -> None:
    write_report(made.report, tmp_path)
    files = [p.relative_to(folder) for p in sorted(folder.rglob("*")) if p.is_file()]
    assert len(files) > 30
    for name in files:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name
    assert not re.search(r"20\d\d-\d\d-\d\d", (folder / "figures" / "averages.svg").read_text())


def test_results_in_another_order_give_the_same_bytes(made: Made, ran: Ran, tmp_path: Path) -> None:
    results = write(tmp_path / "r.parquet", ran.table.sample(frac=1, random_state=1))
    write_report(report([results], made.folder, lambda name, count: None), tmp_path / "out")
    files = [p.relative_to(ran.out) for p in sorted(ran.out.rglob("*")) if p.is_file()]
    assert len(files) > 20
    for name in files:
        assert (tmp_path / "out" / name).read_bytes() == (ran.out / name).read_bytes(), name
    assert not re.search(r"20\d\d-\d\d-\d\d", (ran.out / "figures" / "averages.svg").read_text())


def test_every_figure_explains_how_to_read_it(folder: Path) -> None:
    page = (folder / "report.html").read_text()
    found = re.findall(r'<figcaption>(.*?) <a class="files" href="figures/(\w+)\.svg">', page, re.DOTALL)
    names = {
        "averages", "dimensions", "comparisons", "pairs", "positions", "flips", "mistakes", "filtered", "curves",
        "entanglement", "entanglement_models", "entanglement_bands", "items", "short_form",
    }  # fmt: skip
    assert {name for _, name in found} == {path.stem for path in (folder / "figures").iterdir()} == names
    assert all(len(reading) > 40 for reading, _ in found)


def test_csv_tables_hold_what_the_json_holds(made: Made, folder: Path) -> None:
    table = pd.read_csv(folder / "tables" / "perception.csv")
    (average,) = table[(table["system"] == "ideal") & table["task"].isna() & table["dimension"].isna()]["accuracy"]
    line = next(x for x in made.report.tables[0].lines if x.system == "ideal")
    assert average == pytest.approx(line.average.value)


def _plain(cell: str) -> str:
    """The characters of a cell at full size."""
    cell = re.sub(r"\{\\tiny [^{}]*\}|\\shortstack|\\parbox\[t\]\{3.2cm\}|\\raggedright", "", cell)
    return re.sub(r"[\\{}$]", "", cell).strip()


def test_latex_tables_are_whole_and_escaped(folder: Path) -> None:
    for path in (folder / "tables").glob("*.tex"):
        said = path.read_text()
        blocks = re.findall(r"\\begin\{tabular\}\{l(c+)\}(.*?)\\end\{tabular\}", said, re.DOTALL)
        assert len(blocks) == said.count(r"\begin{tabular}") > 0
        for columns, block in blocks:
            rows = [row for row in block.splitlines() if row.endswith(r"\\")]
            assert {row.count(" & ") for row in rows} == {len(columns)}, path.name
            cells = [[_plain(cell) for cell in row.removesuffix(r"\\").split(" & ")] for row in rows[1:]]
            widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
            assert min(widths[0], 24) + sum(1.5 + width for width in widths[1:]) <= 62, "it fits a column"
        assert not re.search(r"(?<!\\)[%#]", said), path.name


# ---------------------------------------------------------------- the page


@pytest.fixture
def page(browser: Any, folder: Path) -> Iterator[Any]:
    yield from opened(browser, folder / "report.html")


def test_the_page_opens_and_shows_every_figure(page: Any, made: Made) -> None:
    shown = page.eval_on_selector_all("figure img", "all => all.map(i => i.complete && i.naturalWidth > 100)")
    assert len(shown) == 14
    assert all(shown)
    assert page.evaluate("document.documentElement.scrollWidth") <= 1280
    cells = page.eval_on_selector_all("tr.people td.average", "all => all.map(c => parseFloat(c.innerText))")
    people = [line.average.value for t in made.report.tables for line in t.lines if line.system == "people"]
    assert cells == pytest.approx([round(100 * value, 1) for value in people], abs=0.051)
    assert barriers(page) == []


def test_links_of_the_page_lead_to_files(folder: Path) -> None:
    class Links(HTMLParser):
        def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
            href = dict(attrs).get("href")
            if href and not href.startswith(("#", "data:")):
                found.append(href)

    found: list[str] = []
    Links().feed((folder / "report.html").read_text())
    assert len(found) > 20
    assert [href for href in found if not (folder / href).is_file()] == []


def test_names_of_models_cannot_write_into_the_page(ran: Ran) -> None:
    page = (ran.out / "report.html").read_text()
    assert "alert(1)" in page
    assert "<script>" not in page


# ---------------------------------------------------------------- bad input


def test_bad_input_is_reported_with_a_remedy(made: Made, tmp_path: Path) -> None:
    broken = tmp_path / "broken.parquet"
    broken.write_bytes(b"PAR1 but no more")
    other = tmp_path / "other.parquet"
    pq.write_table(pa.table({"id": ["a"]}), other)
    (tmp_path / "empty").mkdir()
    shard = next((made.folder / "data").rglob("*.parquet"))
    for given, said in (
        (tmp_path / "none.parquet", "is not there"),
        (broken, "cannot be read"),
        (other, "lacks the columns"),
        (shard, "a dataset goes to --dataset"),
        (tmp_path / "empty", "holds no results"),
    ):
        done = run(given)
        assert (done.exit_code, said in done.output) == (2, True), done.output


def test_results_of_another_dataset_are_refused(made: Made, tmp_path: Path) -> None:
    table = answers(made.rows[:3], Rater("a", lambda row: 1.0)).assign(id=["race/999999/q0/mujoco", "x", "y"])
    done = run(write(tmp_path / "r.parquet", table), "--dataset", made.folder)
    assert done.exit_code == 2
    assert "3 questions answered are not in" in done.output


def test_conflicting_replies_are_refused_and_equal_ones_accepted(made: Made, tmp_path: Path) -> None:
    table = answers(made.rows[:60], Rater("a", lambda row: 1.0))
    write(tmp_path / "same" / "1.parquet", table)
    write(tmp_path / "same" / "2.parquet", table)
    done = run(tmp_path / "same", "-o", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert json.loads((tmp_path / "out" / "report.json").read_text())["accounts"][0]["replies"] == 60
    write(tmp_path / "same" / "3.parquet", answers(made.rows[:60], Rater("a", lambda row: 0.0)))
    done = run(tmp_path / "same", "-o", tmp_path / "out")
    assert done.exit_code == 2
    assert "two different replies" in done.output
