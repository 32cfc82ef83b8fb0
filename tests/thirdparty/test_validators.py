"""USD's own validators and NVIDIA's find nothing wrong with any stage of the catalogue, and would if there were."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from pxr import Usd, UsdValidation
from usd_validation_nvidia import IssueSeverity, ValidationEngine
from usd_validation_nvidia.rules import UsdAsciiPerformanceChecker

from tests.language.specs import SPECS

#: Writes the stages of a spec.
Stages = Callable[[Path], list[Path]]


def pixar(path: Path) -> list[str]:
    """What the validators of OpenUSD complain about."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(Usd.Stage.Open(str(path)))
    return [f"{path.name}: {error.GetErrorAsString()}" for error in errors]


def nvidia(path: Path) -> list[str]:
    """What the rules of usd-validation-nvidia call an error or a failure: warnings concern smaller or neater files."""
    engine = ValidationEngine()
    engine.disable_rule(UsdAsciiPerformanceChecker)  # our stages are text on purpose: what differs is to be read
    issues = engine.validate(str(path)).issues()
    bad = [issue for issue in issues if issue.severity in (IssueSeverity.ERROR, IssueSeverity.FAILURE)]
    return [f"{path.name}: {issue.message} ({issue.at})" for issue in bad]


@pytest.mark.parametrize(
    ("specs", "most"), [(SPECS[::8], 2), pytest.param(SPECS, None, marks=pytest.mark.slow)], ids=["few", "all"]
)
def test_openusd_has_no_complaint(stages: Stages, specs: list[Path], most: int | None) -> None:
    """Two stages of every eighth spec; where slow tests run, all stages of all specs.

    Counterfactuals have the same kinds of prims as the instance.
    """
    validated = [path for spec in specs for path in stages(spec)[:most]]
    assert len(validated) > len(specs), "most have a base and an instance"
    assert [said for path in validated for said in pixar(path)] == []


@pytest.mark.slow
def test_nvidia_has_no_complaint(stages: Stages) -> None:
    assert [said for spec in SPECS for path in stages(spec) for said in nvidia(path)] == []


def test_both_complain_about_what_is_wrong(stages: Stages, tmp_path: Path) -> None:
    base, *_ = next(filter(None, map(stages, SPECS)))
    wrong = tmp_path / "wrong.usda"
    text = base.read_text()
    wrong.write_text(text.replace('    upAxis = "Z"\n', "").replace('defaultPrim = "World"', 'defaultPrim = "Nowhere"'))
    assert pixar(wrong)
    assert nvidia(wrong)
