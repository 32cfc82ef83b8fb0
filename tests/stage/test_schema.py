"""The codeless schema: known to USD once imported, in step with its readable source, harmless where it is unknown."""

from __future__ import annotations

import subprocess
import sys

import pytest
from pxr import Sdf, Usd

from tests.stage.stages import DATA
from wmspec.sim.usd import schema
from wmspec.sim.usd.actions import TOKENS

TYPES = ("WmsEpisode", "WmsAction", "WmsObservation")
FOLDER = schema.__path__[0]


@pytest.mark.parametrize("name", TYPES)
def test_usd_knows_the_types(name: str) -> None:
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/a", name)
    assert [kind for kind in TYPES if prim.IsA(kind)] == [name]
    assert Usd.SchemaRegistry().FindConcretePrimDefinition(name).GetDocumentation()


def test_the_verbs_are_those_of_the_reader() -> None:
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/a", "WmsAction")
    assert tuple(prim.GetAttribute("wms:verb").GetMetadata("allowedTokens")) == TOKENS


def facts(layer: Sdf.Layer, name: str) -> dict[str, str]:
    """The properties of a class: name -> type, fallback and description."""
    properties = layer.GetPrimAtPath(f"/{name}").properties
    keys = ("typeName", "default", "variability", "documentation", "allowedTokens")
    return {p.name: str([p.GetInfo(key) for key in keys if p.HasInfo(key)]) for p in properties}


def test_readable_source_is_equal() -> None:
    """schema.usda has a header that usdGenSchema reads; the classes are those of generatedSchema.usda."""
    source, generated = (Sdf.Layer.FindOrOpen(f"{FOLDER}/{file}.usda") for file in ("schema", "generatedSchema"))
    for name in TYPES:
        assert facts(source, name) == facts(generated, name)


LATE = """
from pxr import Usd
stage = Usd.Stage.Open({path!r})
assert not stage.GetPrimAtPath("/World/Episode").IsA("WmsEpisode") and stage.GetPrimAtPath("/World/Episode")
from wmspec.sim.usd import read
print(read(stage))
"""
EARLY = """
from wmspec.sim.usd import read
from pxr import Usd
print(read(Usd.Stage.Open({path!r})))
"""


def printed(code: str) -> str:
    """What a fresh Python prints."""
    command = [sys.executable, "-c", code.format(path=str(DATA / "collide.usda"))]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_a_stage_opened_before_the_schema_is_known_reads_the_same() -> None:
    late = printed(LATE)
    assert late == printed(EARLY)
    assert "Launch(" in late
