"""Hostile input: datasets, traces, stages, meshes and pictures that are not what they seem."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from click.testing import CliRunner, Result
from PIL import Image

from wmspec.cli import main

STAGE = """#usda 1.0
( metersPerUnit = 1
  upAxis = "Z" )
def WmsEpisode "Episode" {{ string wms:task = {task}
  double wms:duration = 0.1
}}
def Sphere "ball" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {{ double radius = 0.1
}}
"""


def wmspec(*arguments: object) -> Result:
    """The command line; an exception that nobody foresaw is raised, as a traceback would be."""
    result = CliRunner().invoke(main, [str(a) for a in arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def below(folder: Path) -> set[Path]:
    return {path for path in folder.rglob("*") if path.is_file()}


def png(side: int = 8) -> bytes:
    out = io.BytesIO()
    Image.effect_noise((side, side), 80).save(out, "PNG")
    return out.getvalue()


def rewritten(folder: Path, shard: str, change: Callable[[list[dict[str, Any]]], None]) -> None:
    """Change the rows of a shard, and the manifest so that it has its hash: whoever wrote it meant it so."""
    path = folder / shard
    table = pq.read_table(path)
    rows = table.to_pylist()
    change(rows)
    pq.write_table(pa.Table.from_pylist(rows, schema=table.schema), path)
    signed(folder, shard)


def signed(folder: Path, shard: str) -> None:
    def hashed(manifest: dict[str, Any]) -> None:
        manifest["shards"][shard]["sha256"] = hashlib.sha256((folder / shard).read_bytes()).hexdigest()

    edited(folder, hashed)


def edited(folder: Path, change: Callable[[dict[str, Any]], None]) -> None:
    """Change the manifest."""
    manifest = json.loads((folder / "manifest.json").read_bytes())
    change(manifest)
    (folder / "manifest.json").write_text(json.dumps(manifest))


def resaved(path: Path, **arrays: Any) -> None:
    """Change arrays of a trace."""
    with np.load(path) as file:
        kept = dict(file)
    kept |= {name: value(kept[name]) if callable(value) else value for name, value in arrays.items()}
    np.savez(path, **{name: value for name, value in kept.items() if value is not None})
