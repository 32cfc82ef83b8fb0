"""Hostile stages are refused in bounded time, before USD opens what they name."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from wmspec.api.episode import open_stage
from wmspec.core.diagnostics import WmsError
from wmspec.sim.usd import read
from wmspec.sim.usd.composed import require_bounded

KIDS = "".join(f'def "k{i}" {{}} ' for i in range(10))
CLIPS = """(
clips = {
dictionary default = {
asset[] assetPaths = [@pipe.usda@]
asset manifestAssetPath = @ok.usda@
string primPath = "/a"
}
}
)"""
TEMPLATE = """(
clips = {
dictionary default = {
string templateAssetPath = "./pipe.###.usda"
double templateStartTime = 1
double templateEndTime = 9
double templateStride = 1
}
}
)"""
VARIANT = """(
variantSets = "v"
variants = {
string v = "y"
}
)
{
variantSet "v" = {
"x" (references = @pipe.usda@</b>) {
}
"y" {
}
}
}"""


def stage(folder: Path, name: str, prims: str, *head: str) -> Path:
    """A stage; braces are put on lines of their own, as the text format needs."""
    lines = re.sub(r"\$\{\w+\}|[{}]", lambda m: {"{": "{\n", "}": "\n}\n"}.get(m[0], m[0]), prims)
    (folder / name).write_text("\n".join(["#usda 1.0", *(["(", *head, ")"] if head else []), lines]))
    return folder / name


def referring(arc: str) -> str:
    """Ten children with an arc each."""
    return "".join(f'def "c{i}" ({arc}) {{}} ' for i in range(10))


def ancestral(folder: Path) -> Path:
    """Each level refers to a prim that exists only by an ancestor's reference."""
    prims = f'def "L0" {{ def "x" {{ {KIDS} }} }}\n'
    for n in range(1, 12):
        prims += f'def "A{n}" (references = </L{n - 1}>) {{}}\ndef "L{n}" {{ def "x" {{ '
        prims += referring(f"references = </A{n}/x>") + "} }\n"
    return stage(folder, "bomb.usda", prims)


def inherited(folder: Path) -> Path:
    prims = f'class "C0" {{ {KIDS} }}\n'
    for n in range(1, 12):
        prims += f'class "C{n}" {{ {referring(f"inherits = </C{n - 1}>")} }}\n'
    return stage(folder, "bomb.usda", prims)


def sublayered(folder: Path) -> Path:
    """The targets of references are in sublayers of the layers that are named."""
    stage(folder, "l0.usda", f'def "R" {{ {KIDS} }}')
    for n in range(1, 10):
        stage(folder, f"r{n}.usda", "", f"subLayers = [@l{n - 1}.usda@]")
        stage(folder, f"l{n}.usda", f'def "R" {{ {referring(f"references = @r{n}.usda@</R>")} }}')
    return stage(folder, "bomb.usda", 'def "R" {}', "subLayers = [@l9.usda@]")


def in_expressions(folder: Path) -> Path:
    stage(folder, "e0.usda", f'def "R" {{ {KIDS} }}')
    for n in range(1, 10):
        arc = 'references = @`"./${P}' + str(n - 1) + '.usda"`@</R>'
        stage(folder, f"e{n}.usda", f'def "R" {{ {referring(arc)} }}')
    variables = 'expressionVariables = {\nstring P = "e"\n}'
    return stage(folder, "bomb.usda", 'def "W" (references = @`"./${P}9.usda"`@</R>) {}', variables)


@pytest.mark.parametrize("bomb", [ancestral, inherited, sublayered, in_expressions], ids=lambda bomb: bomb.__name__)
def test_a_bomb_is_counted(bomb: Callable[[Path], Path], tmp_path: Path) -> None:
    with pytest.raises(WmsError, match="more than 200,000 prims"):
        require_bounded(bomb(tmp_path))


def test_variables_that_expand_to_gigabytes_are_refused(tmp_path: Path) -> None:
    variables = ['string V0 = "aaaaaaaaaaaaaaaa"']
    variables += [f"string V{i} = \"`'${{V{i - 1}}}${{V{i - 1}}}'`\"" for i in range(1, 40)]
    head = "expressionVariables = {\n" + "\n".join(variables) + "\n}"
    with pytest.raises(WmsError, match="characters in a variable expression"):
        require_bounded(stage(tmp_path, "bomb.usda", 'def "W" (references = @`"${V39}"`@</R>) {}', head))


@pytest.mark.parametrize(
    "prims",
    [
        'def "a" (references = @pipe.usda@</b>) {}',
        'def "a" (payload = @pipe.usda@</b>) {}',
        'def "a" (references = @`"./${P}.usda"`@</b>) {}',
        f'def "a" {VARIANT}',
        f'def "a" {CLIPS} {{}}',
        f'def "a" {TEMPLATE} {{}}',
        'def "a" (references = @ok.usda@</b>) {}',
    ],
    ids=["reference", "payload", "expression", "variant", "clip", "template", "sublayer"],
)
def test_a_pipe_is_never_opened(prims: str, tmp_path: Path) -> None:
    for name in ("pipe.usda", "pipe.001.usda"):
        os.mkfifo(tmp_path / name)
    stage(tmp_path, "ok.usda", 'def "b" {}', *(["subLayers = [@pipe.usda@]"] if "ok.usda@<" in prims else []))
    variables = 'expressionVariables = {\nstring P = "pipe"\n}'
    path = tmp_path / "stage.usda"
    path.write_text(f"#usda 1.0\n(\n{variables}\n)\n{re.sub('[{] *[}]', '{' + chr(10) + '}', prims)}\n")
    with pytest.raises(WmsError, match="it is a pipe or a device"):
        require_bounded(path)


@pytest.mark.parametrize(
    "text",
    ['def "a" {\n' * 50_000 + "}\n" * 50_000, f"(\ncustomLayerData = {{\n{'dictionary a = {' * 50_000}"],
    ids=["prims", "dictionaries"],
)
def test_text_that_would_crash_the_reader_does_not_crash_this_process(text: str, tmp_path: Path) -> None:
    path = tmp_path / "deep.usda"
    path.write_text("#usda 1.0\n" + text)
    with pytest.raises(WmsError, match="is damaged, or needs too much time or memory"):
        require_bounded(path)


def test_a_stage_of_ordinary_parts_passes(tmp_path: Path) -> None:
    stage(tmp_path, "part.usda", f'def "R" {{ {KIDS} }}', 'defaultPrim = "R"')
    require_bounded(stage(tmp_path, "stage.usda", referring("references = @part.usda@")))


def test_cameras_without_number_are_not_read(tmp_path: Path) -> None:
    path = stage(tmp_path, "many.usda", "".join(f'def Camera "c{n}" {{}} ' for n in range(1001)))
    with pytest.raises(WmsError, match="has more than 1,000 cameras"):
        read(open_stage(path), strict=False)
