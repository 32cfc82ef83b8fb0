"""The formatter: it settles at once, keeps every comment and never changes what a spec means."""

import re
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from tests.examples import examples
from tests.language.specs import SPECS, random_text
from wmspec.cli import main
from wmspec.core.diagnostics import Report, SpecError
from wmspec.core.places import Source
from wmspec.lang.check.ir.record import plain
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.parse.files import library_folder, read_source
from wmspec.lang.parse.format import WIDTH, format_spec
from wmspec.lang.parse.load import load_source

CORPUS = sorted((Path(__file__).parent.parent / "corpus").glob("*.wms"))
SHIPPED = [*SPECS, *sorted(library_folder().glob("*.wms"))]
_WORD = re.compile(r'"""[\s\S]*?"""|"(?:\\.|[^"\\\n])*"|#[^\n]*|[\w.]+|[^\s\w]')


def formatted(text: str) -> str:
    return format_spec(Source("test.wms", text))


def parses(text: str) -> bool:
    try:
        formatted(text)
    except SpecError:
        return False
    return True


def without_places(value: Any) -> Any:
    """The IR as plain values, without where things stood and how conditions were spaced."""
    if isinstance(value, dict):
        return {
            k: re.sub(r"\s+", "", v) if k == "text" and isinstance(v, str) else without_places(v)
            for k, v in value.items()
            if k != "place"
        }
    return [without_places(v) for v in value] if isinstance(value, list | tuple) else value


def meaning(text: str, folder: Path = Path()) -> list[Any]:
    report = Report()
    tasks = check_program(load_source(Source("test.wms", text), folder, report), report)
    return [without_places(plain(task)) for task in tasks]


@st.composite
def respaced(draw: st.DrawFn, text: str) -> str:
    """The same words with other spaces, line breaks and comments between them."""
    out, inside = "", False  # of a docstring
    for line in text.split("\n"):
        kept = inside or '"' in line or "#" in line
        inside ^= line.count('"""') % 2 == 1
        for part in re.split(r"( +)", line):
            if part.strip() or kept:
                out += part
            else:
                out += draw(st.sampled_from([part, " ", "   "]))
        ends = ["\n", "\n", "\n\n\n", "  # why\n", "\n# own\n"]
        out += "\n" if inside or '"' in line else draw(st.sampled_from(ends))
    return out


def comments(text: str) -> list[str]:
    return [w.rstrip() for w in _WORD.findall(text) if w.startswith("#")]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda p: p.stem)
def test_the_shipped_specs_are_formatted(path: Path) -> None:
    assert format_spec(Source(str(path), path.read_text())) == path.read_text()


@pytest.mark.parametrize("every", [3, pytest.param(1, marks=pytest.mark.slow)])
def test_the_corpus(every: int) -> None:
    paths = CORPUS[::every]
    parsed = {path: text for path in paths if parses(text := path.read_text())}
    assert len(parsed) > len(paths) / 2
    for path, text in parsed.items():
        once = formatted(text)
        assert formatted(once) == once, path
        assert meaning(once, path.parent) == meaning(text, path.parent), path


@examples(4, 60)
@given(data=st.data())
def test_random_specs_keep_their_meaning_and_comments(data: st.DataObject) -> None:
    text = data.draw(st.one_of(random_text(), st.sampled_from([p.read_text() for p in SPECS])))
    spaced = data.draw(respaced(text))
    once = formatted(spaced)
    assert formatted(once) == once
    assert comments(once) == comments(spaced)
    assert meaning(once) == meaning(text)


def test_without_spaces_at_the_end_of_lines_and_with_one_at_the_end_of_the_file() -> None:
    text = formatted("use tabletop   # x   \n\n\n\ntask  t:custom{observe front at[0s]}")
    assert text == "use tabletop  # x\n\ntask t : custom {\n  observe front at [0 s]\n}\n"
    assert formatted("") == ""


def test_short_block_stays_on_one_line() -> None:
    assert formatted("object a {shape:cube color:red}") == "object a { shape: cube  color: red }\n"
    assert formatted("object a {shape:cube\ncolor:red}") == "object a {\n  shape: cube\n  color: red\n}\n"
    assert (
        formatted("object a {shape:cube size:6cm\ncolor:red}")
        == "object a {\n  shape: cube  size: 6 cm\n  color: red\n}\n"
    )
    long = "object a {" + " ".join(f"property_{i}: {i}" for i in range(12)) + "}"
    assert all(len(line) <= WIDTH for line in formatted(long).splitlines())
    assert len(formatted(long).splitlines()) == 14


@examples(4, 30)
@given(data=st.data())
def test_a_text_in_pieces_is_the_same_in_one_and_each_piece_has_a_line(data: st.DataObject) -> None:
    text = data.draw(random_text())
    piece = data.draw(st.sampled_from([" ", "  # why\n", "\n\n  # why\n"])).join(['"And"', '"then, {pace}?"'])
    begun = data.draw(st.sampled_from(["question ", "question\n"]))
    spaced = text.replace('question "And then, {pace}?"', begun + piece)
    once = formatted(spaced)
    assert formatted(once) == once
    assert comments(once) == comments(spaced)
    assert meaning(once) == meaning(text)
    rows = once.splitlines()
    row = next(i for i, line in enumerate(rows) if line.endswith('"then, {pace}?" {'))
    above = next(line for line in reversed(rows[:row]) if '"And"' in line)
    assert above.index('"And"') == rows[row].index('"then')


def test_signs_differences_and_calls() -> None:
    assert (
        formatted("let a=-x-3cm*(-2+ f( 1,2 ))\nlet bb=[1,-2]  m/s")
        == "let a  = -x - 3 cm * (-2 + f(1, 2))\nlet bb = [1, -2] m/s\n"
    )


def test_a_line_break_within_a_list_is_kept() -> None:
    assert formatted("factor a in [\n1, # one\n 2 ]") == "factor a in [\n  1,  # one\n  2]\n"


# ---------------------------------------------------------------- the command


def test_files_are_formatted_in_place(tmp_path: Path) -> None:
    file = tmp_path / "a.wms"
    file.write_text("use   tabletop")
    run = CliRunner().invoke
    assert run(main, ["fmt", "--check", str(file)]).exit_code == 1
    shown = run(main, ["fmt", "--diff", str(file)])
    assert (shown.exit_code, "+use tabletop" in shown.output) == (0, True)
    assert file.read_text() == "use   tabletop"
    assert run(main, ["fmt", str(tmp_path)]).exit_code == 0
    assert file.read_text() == "use tabletop\n"
    assert run(main, ["fmt", "--check", str(file)]).exit_code == 0
    assert list(tmp_path.iterdir()) == [file]


def test_standard_input_goes_to_standard_output() -> None:
    result = CliRunner().invoke(main, ["fmt", "-"], input="use   tabletop")
    assert (result.exit_code, result.output) == (0, "use tabletop\n")


def test_file_with_mistakes_is_not_rewritten(tmp_path: Path) -> None:
    file = tmp_path / "a.wms"
    file.write_text("task {")
    result = CliRunner().invoke(main, ["fmt", str(file)])
    assert result.exit_code == 2
    assert "WMS101" in result.output
    assert file.read_text() == "task {"


def test_comments_are_no_part_of_a_condition() -> None:
    text = """use tabletop
task t : custom {
  object a { shape: cube  size: 6 cm  on: table at (0, 0) }
  observe front at [0 s]
  question "Does it?" {
    answer moved(a)
    ensure not moved(a) and  # why "so"
        not contact(a, table)
  }
}
"""
    (task,) = check_program(load_source(Source("test.wms", text), Path(), Report()), Report())
    assert task.questions[0].ensures[0].text == "not moved(a) and not contact(a, table)"


def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path: Path) -> None:
    text = "let a = 1\n"
    (tmp_path / "lib.wms").write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert read_source(tmp_path / "lib.wms").text == text
