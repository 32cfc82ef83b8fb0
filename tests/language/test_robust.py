"""Whatever is written, the answer is a diagnostic and never a traceback."""

from collections import Counter
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.examples import examples
from tests.language.specs import SPECS, task_from
from wmspec.compile.lint import change_rules, regime_rules
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


CROWD = """use tabletop
task crowd : custom {
  factor pace in [10, 12, 14, 16, 18, 20, 22, 24] cm/s
  design groups of 16 { cross: pace }
  objects dot[150] {
    shape: sphere  size: 1 cm  restitution: 0.95
    on: table at (-40 cm + 1.05 cm * (index - 10 * floor(index / 10)), -20 cm + 1.05 cm * floor(index / 10))
  }
  object ball { shape: sphere  size: 4 cm  restitution: 0.95  on: table at (20 cm, 0) }
  action push = launch(ball, direction: right, speed: pace) at 0 s
  observe front at 0 s .. 1 s in 3 frames
  question "Which picture shows the end?" { answer frame(front, 1 s)  options orbit of pace }
  question "Which one is a little before?" { answer frame(front, 0.9 s)  options orbit of pace }
}
"""


def test_a_dry_run_of_many_objects_and_counterfactuals_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fourteen counterfactuals of each instance, and 11,325 pairs of elastic objects of which few are near."""
    calls: Counter[str] = Counter()

    def counted(module: ModuleType, name: str) -> None:
        whole = getattr(module, name)

        def called(*given: Any) -> Any:
            calls[name] += 1
            return whole(*given)

        monkeypatch.setattr(module, name, called)

    counted(change_rules, "build_document")
    counted(regime_rules, "separation")
    dry_run(task_from(CROWD), Report())
    assert 7 <= calls["build_document"] <= 14
    assert 0 < calls["separation"] < 6 * 150 * 4


@examples(8, 300)
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
@settings(max_examples=1000)
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
