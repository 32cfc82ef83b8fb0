"""Any content of an asset file leads to a diagnostic in bounded time, and never to a traceback."""

from __future__ import annotations

import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.assets.specs import CABINET, HERE
from tests.examples import examples
from tests.work import calls
from wmspec.compile.lint.dry_run import dry_run
from wmspec.core.diagnostics import Report, WmsError
from wmspec.core.places import Source
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.parse.load import load_source

TEXTS = [file.read_text() for file in (CABINET, HERE / "pendulum.urdf", HERE / "arm.urdf", HERE / "crane.xml")]
FRAGMENTS = st.sampled_from(
    [
        "<",
        ">",
        '"',
        "/>",
        "-1",
        "0",
        "nan",
        "1e999",
        "<link/>",
        "<joint/>",
        "mesh",
        "&amp;",
        "&x;",
        "\x00",
        "é",
        "9" * 400,
    ]
)
SPEC = 'task t : custom {\nobject a { file: "NAME" }\ncamera front { at: (0, -3 m, 1 m) }\nobserve front at [0 s]\n}'


def reported(folder: Path, content: bytes, name: str = "a.urdf") -> list[str]:
    """The codes of all diagnostics of a spec that names this asset; each can be formatted."""
    (folder / name).write_bytes(content)
    report = Report()
    source = Source(str(folder / "spec.wms"), SPEC.replace("NAME", name))
    for spec in check_program(load_source(source, folder, report), report):
        with suppress(WmsError):
            dry_run(spec, report)
    for d in report.diagnostics:
        assert d.render()
        assert d.record()
    return [d.code for d in report.diagnostics]


@examples(60, 1000)
@given(data=st.data())
def test_mutated_assets(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    text = data.draw(st.sampled_from(TEXTS))
    for _ in range(data.draw(st.integers(1, 3))):
        i = data.draw(st.integers(0, len(text)))
        j = min(len(text), i + data.draw(st.integers(0, 30)))
        text = text[:i] + data.draw(st.one_of(FRAGMENTS, st.text(max_size=5))) + text[j:]
    reported(tmp_path_factory.getbasetemp(), text.encode(errors="replace"))


@examples(40, 600)
@given(data=st.data())
def test_mutated_words_of_assets(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    """Well-formed, with wrong names and numbers."""
    words = data.draw(st.sampled_from(TEXTS)).split('"')
    for _ in range(data.draw(st.integers(1, 4))):
        i = 1 + 2 * data.draw(st.integers(0, len(words) // 2 - 1))
        words[i] = data.draw(st.one_of(st.sampled_from(words[1::2]), st.sampled_from(["", "0", "-1", "1e9", "0 0 0"])))
    reported(tmp_path_factory.getbasetemp(), '"'.join(words).encode())


@examples(50, 500)
@given(content=st.binary(max_size=200))
def test_bytes(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    assert "WMS210" in reported(tmp_path_factory.getbasetemp(), content)


LINK = '<link name="l{0}"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>'
JOINT = '<joint name="j{0}" type="fixed"><parent link="l{1}"/><child link="l{0}"/></joint>'
LARGE = {
    "many bytes": "<robot>" + " " * 4_000_001 + "</robot>",
    "many elements": "<robot>" + "<gazebo/>" * 20_001 + "</robot>",
    "deep": "<robot>" + "<gazebo>" * 10_000,
    "many links": "<robot>" + "".join(LINK.format(i) for i in range(501)) + "</robot>",
    "many shapes": '<robot><link name="l">' + "<visual/>" * 2001 + "</link></robot>",
    "many faults": "<robot>" + "<tendon/>" * 19_000 + "</robot>",
    "entities": '<!DOCTYPE r [<!ENTITY a "' + "a" * 100_000 + '">]><robot name="' + "&a;" * 30_000 + '"/>',
    "a file of others": '<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/hostname">]><robot name="r">&a;</robot>',
    "a long number": '<robot><link name="l"><visual><origin xyz="' + "1" * 3_000_000 + '"/></visual></link></robot>',
}


@pytest.mark.parametrize("what", LARGE)
def test_oversized_input_is_refused_early(tmp_path: Path, what: str) -> None:
    said, work = calls(lambda: reported(tmp_path, LARGE[what].encode()))
    assert "WMS210" in said
    assert work < 2_000_000


def test_a_long_chain_is_no_problem(tmp_path: Path) -> None:
    """A chain of the maximum number of links: nothing recurses."""
    robot = ["<robot>", LINK.format(0)]
    for i in range(1, 500):
        robot += [LINK.format(i), JOINT.format(i, i - 1).replace("<child", '<origin xyz="0.3 0 0"/><child')]
    text = "\n".join([*robot, "</robot>"]).replace("visual>", "collision>")
    assert sys.getrecursionlimit() <= 1000
    assert reported(tmp_path, text.encode()) == []


def test_other_specs_do_not_wait_for_what_reads_assets() -> None:
    code = (
        "import sys; from pathlib import Path; from wmspec.lang.check.statements.task import check\n"
        "from wmspec.core.diagnostics import Report\n"
        f"check(Path({str(HERE.parent / 'corpus/good.wms')!r}), Report())\n"
        "readers = [m for m in sys.modules if m.startswith(('wmspec.lang.importers.', 'numpy', 'xml', 'pxr'))]\n"
        "print(sorted({*readers} - {'wmspec.lang.importers.prim_names'}))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


STAGES = [(HERE / name).read_text() for name in ("balance.usda", "box.usda")]


@examples(20, 200)
@given(data=st.data())
def test_mutated_stages(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    """A new file for each, since USD caches opened files."""
    lines = data.draw(st.sampled_from(STAGES)).split("\n")
    for _ in range(data.draw(st.integers(1, 4))):
        i = data.draw(st.integers(4, len(lines) - 1))
        values = st.sampled_from(
            ["0", "-1", "nan", "inf", "1e30", "(0, 0, 0)", "</balance/left>", '"Z"', "", "[]", "[9]"]
        )
        name, equals, _ = lines[i].partition(" = ")
        lines[i] = f"{name} = {data.draw(values)}" if equals else data.draw(st.sampled_from([lines[i], "", "}"]))
    folder = tmp_path_factory.mktemp("stage")
    reported(folder, "\n".join(lines).encode(), "a.usda")
