"""Files that specs name: found beside the spec or library that says so, varied by factors, never outside."""

from pathlib import Path

import pytest
import trimesh
from PIL import Image

from wmspec.compile.layout.meshes import load
from wmspec.core.diagnostics import Report, WmsError
from wmspec.lang.check.ir.ir import Operation, Ref, TaskSpec, Value
from wmspec.lang.check.statements.task import check

TASK = "use tabletop\ntask t : custom {{\n  {0}\n  observe front at [0 s]\n}}\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("cup.obj", "deep/mug.obj", "label.png"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    Image.new("RGB", (4, 4)).save(tmp_path / "label.png")
    return tmp_path


def checked(folder: Path, body: str) -> tuple[TaskSpec | None, list[str]]:
    (folder / "spec.wms").write_text(TASK.format(body))
    report = Report()
    specs = check(folder / "spec.wms", report)
    return (specs[0] if specs else None), [d.code for d in report.diagnostics]


def test_file_is_found_next_to_the_spec(folder: Path) -> None:
    spec, codes = checked(folder, 'object a { file: "deep/mug.obj"  image: "label.png"  on: table }')
    assert codes == []
    assert spec is not None
    assert spec.thing("a").properties["file"].value == Value(value=f"{folder}/deep/mug.obj")
    assert {"shape", "size"} & spec.thing("a").properties.keys() == set()


def test_a_factor_chooses_between_files(folder: Path) -> None:
    spec, codes = checked(folder, 'factor mesh in ["cup.obj", "deep/mug.obj"]\nobject a { file: mesh  on: table }')
    assert codes == []
    assert spec is not None
    whole = Operation(operator="+", operands=(Value(value=f"{folder}/"), Ref(name="mesh")))
    assert spec.thing("a").properties["file"].value == whole


def test_a_library_names_files_beside_itself(folder: Path) -> None:
    (folder / "deep/mugs.wms").write_text('template mug(mesh: "mug.obj") { file: mesh  on: table }\n')
    (folder / "deep/spec.wms").write_text(TASK.format("object a : mug { }").replace("use", "use mugs\nuse"))
    report = Report()
    (spec,) = check(folder / "deep/spec.wms", report)
    assert spec.thing("a").properties["file"].value == Value(value=f"{folder.resolve()}/deep/mug.obj")


@pytest.mark.parametrize(
    "name", ["none.obj", "../cup.obj", "/cup.obj", "C:/cup.obj", "deep\\\\mug.obj", "label.png", ""]
)
def test_other_files_are_refused(folder: Path, name: str) -> None:
    assert checked(folder, f'object a {{ file: "{name}"  on: table }}')[1] == ["WMS210"]


def test_one_bad_value_of_a_factor_is_enough(folder: Path) -> None:
    body = 'factor mesh in ["cup.obj", "none.obj"]\nobject a { file: mesh  on: table }'
    assert checked(folder, body)[1] == ["WMS210"]


def test_libraries_are_found_on_the_search_path(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "deep/playthings.wms").write_text("object toy { shape: cube }\n")
    body = "use playthings\nobject a { on: toy }"
    assert checked(folder, body)[1] == ["WMS207"]  # what it would have brought is not reported as well
    monkeypatch.setenv("WMSPEC_PATH", f"/nowhere:{folder / 'deep'}")
    assert checked(folder, body)[1] == []


@pytest.mark.parametrize("scale", [1e5, 1e308])
def test_a_mesh_is_not_larger_than_other_things(folder: Path, scale: float) -> None:
    trimesh.creation.box((1, 1, 1)).export(folder / "cup.obj")
    assert load(str(folder / "cup.obj"), 10, "hull", True).volume == pytest.approx(1000)
    with pytest.raises(WmsError, match="km large with this scale; the most is 10 km"):
        load(str(folder / "cup.obj"), scale, "hull", True)
