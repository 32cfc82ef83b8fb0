"""Whatever is written, the answer is a diagnostic and never a traceback."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.examples import examples
from tests.language.specs import SPECS
from wmspec.compile.lint.dry_run import dry_run
from wmspec.core.diagnostics import Report, WmsError
from wmspec.core.places import Source
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.parse.load import load_source

TEXTS = [p.read_text() for p in [*SPECS, *sorted((Path(__file__).parent.parent / "corpus").glob("[a-c]*.wms"))]]
FRAGMENTS = st.sampled_from(
    ["{", "}", "(", "]", '"', "..", " in ", "at", "3 cm", "-", "if", "task", "\x00", "é", "#", "1e999", "*", ":", "."]
)


def survive(text: str) -> None:
    report = Report()
    try:
        for spec in check_program(load_source(Source("fuzz.wms", text), Path(), report), report):
            dry_run(spec, report)
    except WmsError:
        pass
    for diagnostic in report.diagnostics:
        assert diagnostic.render()
        assert diagnostic.record()


@examples(20, 300)
@given(data=st.data())
def test_mutated_specs(data: st.DataObject) -> None:
    text = data.draw(st.sampled_from(TEXTS))
    for _ in range(data.draw(st.integers(1, 4))):
        i = data.draw(st.integers(0, len(text)))
        j = min(len(text), i + data.draw(st.integers(0, 12)))
        text = text[:i] + data.draw(st.one_of(FRAGMENTS, st.text(max_size=5))) + text[j:]
    survive(text)


@examples(150, 1500)
@given(st.text())
def test_random_text(text: str) -> None:
    survive(text)


@examples(80, 800)
@given(
    st.lists(
        st.one_of(FRAGMENTS, st.sampled_from(["task", "object", "factor", "let", "action", "question", "x", "red"])),
        max_size=40,
    )
)
def test_random_words(words: list[str]) -> None:
    survive(" ".join(words))


@pytest.mark.slow
@settings(max_examples=3000)
@given(data=st.data())
def test_heavily_mutated_specs(data: st.DataObject) -> None:
    """The same for longer; `benchmarks/fuzz.py` goes on from here, with limits of time and memory."""
    text = data.draw(st.sampled_from(TEXTS))
    for _ in range(data.draw(st.integers(1, 12))):
        i = data.draw(st.integers(0, len(text)))
        j = min(len(text), i + data.draw(st.integers(0, 60)))
        middle = data.draw(st.one_of(FRAGMENTS, st.text(max_size=20), st.just(text[i:j] * 3)))
        text = text[:i] + middle + text[j:]
    survive(text)
