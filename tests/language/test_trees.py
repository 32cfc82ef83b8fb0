"""For every text of the grammar, printing and reading is the identity, and formatting changes only space."""

from hypothesis import given

from tests.language.trees import bare, files, written
from wmspec.core.diagnostics import Report
from wmspec.core.places import Source
from wmspec.lang.parse.format import format_spec
from wmspec.lang.parse.parser import parse
from wmspec.lang.parse.syntax import File


def _read(text: str) -> File:
    report = Report()
    tree = parse(Source("tree.wms", text), report)
    report.stop_if_failed()
    return tree


@given(files)
def test_a_tree_reads_back_as_it_was_printed(tree: File) -> None:
    assert bare(_read(written(tree))) == bare(tree)


@given(files)
def test_formatting_keeps_the_tree_and_a_second_time_changes_nothing(tree: File) -> None:
    once = format_spec(Source("tree.wms", written(tree)))
    assert bare(_read(once)) == bare(tree)
    assert format_spec(Source("tree.wms", once)) == once
