"""The notebooks run from beginning to end, and print what they are shown to print."""

from __future__ import annotations

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from tests.engines import installed
from tests.examples import slow_except

FOLDER = Path(__file__).parents[2] / "docs/notebooks"
NEEDS = {"first_scene": ["mujoco"], "factor_study": ["mujoco", "pybullet", "sapien"], "own_engine": ["mujoco"]}


def test_there_is_a_test_for_each() -> None:
    assert {path.stem for path in FOLDER.glob("*.ipynb")} == NEEDS.keys()


@pytest.mark.pixels
@pytest.mark.parametrize("name", slow_except(NEEDS.keys() - {"factor_study"}, NEEDS))
def test_it_runs_from_beginning_to_end(name: str, tmp_path: Path) -> None:
    for engine in NEEDS[name]:
        installed(engine)
    shown = nbformat.read(FOLDER / f"{name}.ipynb", 4)
    run = nbformat.from_dict(shown)
    NotebookClient(run, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert [kinds(cell) for cell in run.cells] == [kinds(cell) for cell in shown.cells], "its outputs are not current"
    assert not any(out.get("name") == "stderr" for cell in run.cells for out in cell.get("outputs", []))


def kinds(cell: nbformat.NotebookNode) -> set[str]:
    """What a cell shows: a picture, a table, a text."""
    return {kind for out in cell.get("outputs", []) for kind in out.get("data", {"text/plain": ""})}
