"""Untrusted text is shown on a terminal, and not obeyed by it; excess is reported in a sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.trust.made import wmspec
from wmspec.core.diagnostics import WmsError, escape_controls
from wmspec.core.places import FilePlace

SPEC = Path(__file__).parents[1] / "endtoend/specs/speed_tabletop.wms"


@pytest.mark.parametrize("text", ["\x1b]0;title\x07", "\x1b[2J", "\r", "\x9b31m", "\u202e", "\x7f"])
def test_control_characters_are_escaped(tmp_path: Path, text: str) -> None:
    (tmp_path / "t.wms").write_text(f"task t : custom {{\n  let a = frob{text}(3)\n}}\n", newline="")
    output = wmspec("check", tmp_path / "t.wms").output
    assert text[0] not in output
    assert text[0] not in WmsError(f"there is no `{text}`", FilePlace(f"{text}.usda"), f"find `{text}`").render()
    assert len(escape_controls(text)) == len(text), "carets stay below what they point at"


def test_lines_and_letters_are_reported_verbatim() -> None:
    text = "two\n\tlines: naïve, 日本, −5 °C"
    assert escape_controls(text) == text


def test_astronomical_number_of_instances(tmp_path: Path) -> None:
    """2·10⁹ instances ended with a MemoryError."""
    text = SPEC.read_text().replace("repeat 33", "repeat 1000000").replace("task speed_tabletop", "task many")
    text = text.replace("  factor   ratio", "  factor   idle       in 1 .. 30 by 1\n  factor   ratio")
    (tmp_path / "many.wms").write_text(text)
    for more in ([], ["--full"]):
        result = wmspec("generate", tmp_path / "many.wms", "-b", "mujoco", "-o", tmp_path / "out", *more)
        assert result.exit_code == 2
        assert "`many` has more than 10,000,000 instances; generate fewer: use --per-task" in result.output
    assert not (tmp_path / "out").exists()
