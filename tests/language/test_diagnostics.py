"""The one kind of diagnostic: it crosses process borders whole, is reported once, and says where."""

import ast
import pickle
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wmspec.cli.sarif import sarif
from wmspec.compile.lint import change_rules, option_rules, scene_rules, task_rules
from wmspec.core.diagnostics import Diagnostic, Note, Report, SpecError, StageError, WmsError, escape_controls
from wmspec.core.places import FilePlace, Location, Place, PrimPlace, Source, Span
from wmspec.lang.parse.codes import CODES
from wmspec.lang.parse.load import with_source_text

RULES = [r for room in (task_rules, option_rules, scene_rules, change_rules) for r in room.RULES]
RULES += task_rules.DESIGN_RULES
SOURCE = Source("a.wms", "task t : custom {\n  horizon 1 s\n}\n")


def spans() -> st.SearchStrategy[Span]:
    offsets = st.integers(0, len(SOURCE.text))
    return st.tuples(offsets, offsets).map(lambda ends: Span(SOURCE, min(ends), max(ends)))


def places() -> st.SearchStrategy[Place]:
    texts = st.text(min_size=1)
    files = st.builds(FilePlace, texts, st.none() | st.integers(1), st.text())
    return st.one_of(spans(), spans().map(Location.of), texts.map(PrimPlace), files)


def diagnostics() -> st.SearchStrategy[Diagnostic]:
    texts = st.text()
    notes = st.lists(st.builds(Note, texts, places()), max_size=3).map(tuple)
    codes, severities = st.sampled_from([*CODES, ""]), st.sampled_from(["error", "warning"])
    return st.builds(Diagnostic, texts, st.none() | places(), texts, codes, notes, severities)


def subclasses(error: type[WmsError]) -> list[type[WmsError]]:
    return [error, *(deeper for nearer in error.__subclasses__() for deeper in subclasses(nearer))]


@given(st.sampled_from(subclasses(WmsError)), st.lists(diagnostics(), min_size=1))
def test_an_error_crosses_a_process_border_whole(error: type[WmsError], reported: list[Diagnostic]) -> None:
    again = pickle.loads(pickle.dumps(error.of(reported)))
    assert type(again) is error
    assert again.diagnostics == tuple(reported)
    assert str(again) == "\n".join(map(str, reported))


@given(st.lists(diagnostics()), st.randoms())
def test_report_lists_each_once_in_text_order(reported: list[Diagnostic], random) -> None:
    report = Report(StageError)
    report.include(reported)
    report.include(random.sample(reported, len(reported)))
    keys = [(d.code, str(d.place), d.message) for d in report.diagnostics]
    assert sorted(keys) == sorted({(d.code, str(d.place), d.message) for d in reported})
    in_text = [d.place.start for d in report.diagnostics if isinstance(d.place, Span | Location)]
    assert in_text == sorted(in_text)
    assert report.failed == any(d.severity == "error" for d in report.diagnostics)


@given(diagnostics())
def test_every_form_of_a_diagnostic_has_its_message(reported: Diagnostic) -> None:
    for text in (str(reported), reported.render()):
        shown = escape_controls if text == reported.render() else str  # what a terminal would obey is shown instead
        assert shown(reported.message) in text
        assert shown(reported.help) in text
        assert reported.place is None or shown(str(reported.place)) in text
    record = reported.record()
    assert (record["message"], record["code"], record["help"]) == (reported.message, reported.code, reported.help)
    assert len(record["notes"]) == len(reported.notes)  # type: ignore[arg-type]


@given(spans())
def test_the_text_of_a_location_is_found_again(span: Span) -> None:
    (again,) = with_source_text([Diagnostic("m", Location.of(span))])
    assert again.place == Location.of(span)  # there is no such file


def test_the_text_at_a_location_is_read_from_its_file(tmp_path: Path) -> None:
    source = Source(str(tmp_path / "a.wms"), SOURCE.text)
    Path(source.name).write_text(source.text)
    span = Span(source, source.text.index("horizon"), source.text.index(" s\n"))
    note = Note("here", Location.of(span))
    (again,) = with_source_text([Diagnostic("m", Location.of(span), notes=(note,))])
    assert again.place == span
    assert again.notes[0].place == span
    assert "2 |   horizon 1 s" in again.render()


def test_only_the_places_and_the_words_that_lead_are_coloured() -> None:
    span = Span(SOURCE, 0, 4)
    reported = Diagnostic("error: help: ^^", span, "note: that", "WMS101", (Note("warning", span),))
    painted = reported.render(lambda text, part: f"<{part}>{text}</>")
    heads = [line.split("</>")[0] for line in painted.splitlines() if line.startswith("<")]
    carets = "<caret>  | ^^^^"
    assert heads == ["<error>error[WMS101]", carets, "<note>note", carets, "<help>help"]


def test_diagnostics_without_a_text_position_have_a_result() -> None:
    reported = [Diagnostic("m", place, code="WMS210") for place in (None, PrimPlace("/World"), FilePlace("a.urdf", 3))]
    nowhere, prim, file = (r for r in sarif(reported)["runs"][0]["results"])
    assert "locations" not in nowhere
    assert prim["locations"][0]["logicalLocations"] == [{"fullyQualifiedName": "/World"}]
    assert file["locations"][0]["physicalLocation"]["region"] == {"startLine": 3}


# ---------------------------------------------------------------- rules


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.breaches.__name__)
def test_every_rule_has_a_code_with_a_page_and_says_what_it_finds(rule) -> None:
    assert rule.code in CODES
    assert rule.breaches.__doc__


def test_an_error_at_a_place_keeps_the_places_that_it_has() -> None:
    known, here = Location.of(Span(SOURCE, 0, 4)), PrimPlace("/World")
    both = SpecError.of([Diagnostic("a"), Diagnostic("b", known)])
    assert [d.place for d in both.at(here).diagnostics] == [here, known]


# ---------------------------------------------------------------- over the whole code

ROOT = Path(__file__).parents[2]
CODE = [*sorted((ROOT / "wmspec").rglob("*.py")), *sorted((ROOT / "backends").rglob("*.py"))]
PARSING = {"startswith", "endswith", "partition", "rpartition", "split", "splitlines", "match", "search", "fullmatch"}


def breaks(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Errors that write a place into their text, and texts of errors that are taken apart: the line and what."""
    ours = {error.__name__ for error in subclasses(WmsError)} | {"Diagnostic", "Breach"}
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Name(id=name), args=[ast.JoinedStr(values=[ast.FormattedValue(), second, *_]), *_]):
                if name in ours and isinstance(second, ast.Constant) and str(second.value).startswith(": "):
                    yield node.lineno, f"{name} begins with a place"
            case ast.ExceptHandler(type=ast.expr() as caught, name=str(name)) if names(caught) & ours:
                for inner in ast.walk(node):
                    if isinstance(inner, ast.Call) and isinstance(inner.func, ast.Attribute):
                        taken = [inner.func.value, *inner.args]
                        if inner.func.attr in PARSING and any(reported_by(part, name) for part in taken):
                            yield inner.lineno, f"{inner.func.attr} of the text of an error"


def names(node: ast.AST) -> set[str]:
    return {inner.id for inner in ast.walk(node) if isinstance(inner, ast.Name)}


def reported_by(node: ast.AST, name: str) -> bool:
    """Whether this is the text of the error of that name."""
    match node:
        case ast.Call(func=ast.Name(id="str"), args=[ast.Name(id=of)]):
            return of == name
        case ast.JoinedStr():
            return name in names(node)
    return False


def test_places_are_values_and_no_text_of_an_error_is_read_back() -> None:
    broken = {str(path.relative_to(ROOT)): list(breaks(ast.parse(path.read_text()))) for path in CODE}
    assert not {file: breach for file, breach in broken.items() if breach}


@pytest.mark.parametrize(
    "code",
    [
        'raise WmsError(f"{place}: no")',
        'try: f()\nexcept WmsError as e: g(str(e).startswith("error["))',
        'try: f()\nexcept (OSError, StageError) as e: re.match("a:", str(e))',
    ],
)
def test_code_that_would_is_found(code: str) -> None:
    assert list(breaks(ast.parse(code)))
