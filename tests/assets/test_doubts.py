"""What a file says and cannot be honoured does not matter where the spec says it itself."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.assets.specs import checked

URDF = """<robot name="r"><material name="m"><texture filename="m.png"/></material>
<link name="a"><visual><geometry><sphere radius="1"/></geometry><material name="m"/></visual></link>
<link name="b"><visual><geometry><box size="1 1 1"/></geometry><material name="x"><color rgba="1 0 0 0.5"/></material>
</visual><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint></robot>"""
MJCF = """<mujoco><asset><material name="m" texture="t"/></asset><worldbody><body name="a"><geom size="1" material="m"/>
<body name="b"><geom size="1" rgba="1 0 0 0.5"/></body></body></worldbody></mujoco>"""
FILES = {"urdf": URDF, "xml": MJCF}
TEXTURED, TRANSPARENT = "textures of an asset are not supported", "what is transparent is not supported"


def reported(folder: Path, ending: str, said: str) -> set[str]:
    """What is wrong with a spec that says this of an asset, without where in the file."""
    (folder / f"a.{ending}").write_text(FILES[ending])
    text = f'task t : custom {{ object o {{ file: "a.{ending}"  at: (0, 0, 0)  {said} }} }}'
    (folder / "spec.wms").write_text(text)
    found = checked(folder / "spec.wms")[1].diagnostics
    return {d.message.rpartition(": ")[0].rpartition(": ")[2] for d in found if d.code == "WMS211"}


@pytest.mark.parametrize("ending", FILES)
@pytest.mark.parametrize(
    ("said", "left"),
    [
        ("", {TEXTURED, TRANSPARENT}),
        ("roughness: 0.2  part a { friction: 0.2 }", {TEXTURED, TRANSPARENT}),
        ("part b { color: red }", {TEXTURED}),
        ("part a { material: wood }  part b { color: red }", set()),
        ("color: blue", set()),
    ],
)
def test_looks_of_the_spec_override_those_of_the_file(tmp_path: Path, ending: str, said: str, left: set[str]) -> None:
    assert reported(tmp_path, ending, said) == left
