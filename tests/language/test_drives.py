"""Drives that some engines refuse as too stiff are reported before anything is executed."""

from __future__ import annotations

import pytest

from tests.engines import installed
from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.compile.lint.dry_run import dry_run
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.core.diagnostics import Report, WmsError
from wmspec.sim.usd import read

SPEC = """use room

task t : custom {{
  factor tone in [red, blue]
  object post {{ shape: box  size: (4 cm, 4 cm, 40 cm)  at: (0, 30 cm, 20 cm)  fixed: true }}
  object door {{ shape: box  size: (2 cm, 20 cm, 3 cm)  color: tone  at: (0, 18 cm, 20 cm)  mass: 100 g }}
  joint j : {kind} {{ of: door  to: post  at: (0, 28 cm, 20 cm)  {drive} }}
  observe front at [0 s, 0.1 s]
}}
"""


def moment() -> float:
    """The moment of inertia of the door about its hinge, kg m²."""
    return 0.1 * ((0.02**2 + 0.2**2) / 12 + 0.1**2)


def test_an_armature_is_load() -> None:
    drive = f"stiffness: {1.01 * 0.5 * (16 * 1920) ** 2 * 0.1:.6f}"
    for more, found in (("", 1), ("armature: 0.01", 0)):
        task, report = task_from(SPEC.format(kind="slider", drive=f"{drive} {more}")), Report()
        dry_run(task, report)
        assert [d.code for d in report.diagnostics].count("WMS608") == found
    (joint,) = read(compose(document(task, Design(task)[0]))).joints
    assert joint.armature == pytest.approx(0.01)


LIMITS = [
    ("slider", "stiffness", 0.5 * (16 * 1920) ** 2 * 0.1),
    ("slider", "damping", 0.5 * 16 * 1920 * 0.1),
    ("hinge", "stiffness", 0.5 * (16 * 1920) ** 2 * moment()),
    ("hinge", "damping", 0.5 * 16 * 1920 * moment()),
]


@pytest.mark.parametrize("factor", [0.99, 1.01])
@pytest.mark.parametrize(("kind", "word", "most"), LIMITS)
def test_check_reports_what_the_coarsest_engine_refuses(kind: str, word: str, most: float, factor: float) -> None:
    task, report = task_from(SPEC.format(kind=kind, drive=f"{word}: {most * factor:.6f}")), Report()
    dry_run(task, report)
    found = [d.message for d in report.diagnostics if d.code == "WMS608"]
    assert [f"the {word} of `j` is too high for its load `door`" in message for message in found] == [True] * (
        factor > 1
    )
    scene = read(compose(document(task, Design(task)[0])))
    if factor > 1:
        with pytest.raises(WmsError, match="stiff for its load"):
            installed("pybullet").execute(scene)
    else:
        installed("pybullet").execute(scene)
