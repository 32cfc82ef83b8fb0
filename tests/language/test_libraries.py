"""Libraries: found next to the spec, used once, never in a circle."""

from pathlib import Path

from wmspec.core.diagnostics import Report
from wmspec.lang.check.statements.task import check


def codes(path: Path) -> list[str]:
    report = Report()
    check(path, report)
    return [d.code for d in report.diagnostics]


def test_a_library_next_to_the_spec_is_found(tmp_path: Path) -> None:
    (tmp_path / "stand.wms").write_text("object table { shape: box }\ncamera front { at: (0, -1 m, 1 m) }\n")
    spec = tmp_path / "spec.wms"
    spec.write_text("use stand\ntask t : custom { object a { on: table } observe front at [0 s] }\n")
    assert codes(spec) == []


def test_circular_libraries_are_an_error(tmp_path: Path) -> None:
    (tmp_path / "a.wms").write_text("use b\n")
    (tmp_path / "b.wms").write_text("use a\n")
    spec = tmp_path / "spec.wms"
    spec.write_text("use a\ntask t : custom { }\n")
    assert "WMS208" in codes(spec)


def test_a_name_of_a_library_cannot_be_shadowed(tmp_path: Path) -> None:
    spec = tmp_path / "spec.wms"
    spec.write_text("use tabletop\ntask t : custom { object table { } observe front at [0 s] }\n")
    assert codes(spec) == ["WMS202"]
