"""Bullet's `contact` in URDF: friction and restitution of a link."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.assets.specs import checked, scene, spec

LINK = """<robot name="r"><link name="a"><contact>{}</contact>
<inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size=".2 .2 .2"/></geometry></collision></link></robot>"""


def link(contact: str, folder: Path) -> str:
    """An object in a file whose link has these children of `contact`."""
    (folder / "a.urdf").write_text(LINK.format(contact))
    return 'object it { file: "a.urdf"  at: (0, 0, 1 m) }'


def test_contact_sets_friction_and_restitution(tmp_path: Path) -> None:
    contact = '<lateral_friction value="0.2"/><restitution value="0.25"/>'
    (body,) = scene(spec(link(contact, tmp_path), tmp_path)).bodies
    friction = body.geoms[0].friction
    assert (friction.static, friction.dynamic, friction.restitution) == pytest.approx((0.2, 0.2, 0.25))


def test_the_spec_overrides_the_file(tmp_path: Path) -> None:
    text = link('<lateral_friction value="0.2"/>', tmp_path).replace("file:", "friction: 0.9  file:")
    (body,) = scene(spec(text, tmp_path)).bodies
    assert body.geoms[0].friction.dynamic == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("contact", "message"),
    [
        ('<lateral_friction value="-1"/>', "`lateral_friction` is -1"),
        ('<restitution value="2"/>', "`restitution` is 2"),
        ("<lateral_friction/>", "it needs `value`"),
        ('<lateral_friction value="1"/><lateral_friction value="2"/>', "more than one `lateral_friction`"),
    ],
)
def test_a_mistake_is_reported_with_its_line(contact: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "spec.wms"
    path.write_text(
        f"task t : custom {{\n  {link(contact, tmp_path)}\n  camera front {{ at: (0, -3 m, 1 m) }}\n"
        "  observe front at [0 s, 1 s]\n}\n"
    )
    _, report = checked(path)
    (mistake,) = (d for d in report.diagnostics if d.severity == "error")
    assert message in mistake.message
    assert "a.urdf:1" in mistake.message


def test_contact_stiffness_is_ignored_with_a_warning_that_strict_refuses(tmp_path: Path) -> None:
    for strict in ("", "strict: true"):
        text = link('<stiffness value="100"/>', tmp_path).replace("file:", f"{strict}  file:")
        (tmp_path / "spec.wms").write_text(f"task t : custom {{\n  {text}\n}}\n")
        faults = {
            d.severity for d in checked(tmp_path / "spec.wms")[1].diagnostics if "`stiffness` in `contact`" in d.message
        }
        assert faults == {"error" if strict else "warning"}
