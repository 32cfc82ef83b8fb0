"""`wmspec new`: what it writes is a spec without mistakes that gives questions, and nothing is overwritten."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

import wmspec
from tests.engines import installed
from wmspec.cli import main
from wmspec.core.diagnostics import WmsError
from wmspec.core.places import Source
from wmspec.editor.start import first_spec, template_titles, templates
from wmspec.lang.parse.format import format_spec


@pytest.mark.parametrize("template", templates())
def test_a_first_spec_is_without_mistakes_and_well_formed(template: str, tmp_path: Path) -> None:
    path = tmp_path / "marbles.wms"
    path.write_text(first_spec("marbles", template))
    diagnosis = wmspec.diagnose(path)
    assert not diagnosis.diagnostics
    assert [name for name, _ in diagnosis.tasks] == ["marbles"]
    assert format_spec(Source("marbles.wms", path.read_text())) == path.read_text()
    assert template_titles()[template]


@pytest.mark.engine
@pytest.mark.pixels
@pytest.mark.parametrize("template", templates())
def test_a_first_spec_gives_questions(template: str) -> None:
    installed("mujoco")
    task = wmspec.load(text=first_spec("marbles", template))
    probed = [instance.ask("mujoco", size=64) for instance in task.sample(4)]
    assert sum(len(questions) for questions in probed) >= 3


def test_existing_file_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.wms").write_text("mine\n")
    for name in ("mine", "mine.wms"):
        done = CliRunner().invoke(main, ["new", name])
        assert done.exit_code == 2
        assert "already exists" in done.output
    assert Path("mine.wms").read_text() == "mine\n"
    done = CliRunner().invoke(main, ["new", "other", "--template", "perception"])
    assert done.exit_code == 0
    assert "task other : perception" in Path("other.wms").read_text()


@pytest.mark.parametrize(
    ("name", "template", "reported"),
    [
        ("red-ball", "prediction", "try `red_ball`"),
        ("3d", "prediction", "try `task_3d`"),
        ("factor", "prediction", "a word of the language"),
        ("fine", "predictoin", "did you mean `prediction`?"),
    ],
)
def test_impossible_first_spec_has_a_remedy(name: str, template: str, reported: str) -> None:
    with pytest.raises(WmsError, match=reported.replace("?", r"\?")):
        first_spec(name, template)
