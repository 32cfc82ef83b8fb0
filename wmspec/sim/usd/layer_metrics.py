"""Warns about a stage without a unit, and about layers with another unit or up axis: USD does not convert them.

A reference that is scaled, or turned, is taken as converted by its author.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from wmspec.sim.usd.substitutions import Substitutions

_METRES, _UP = "metersPerUnit", "upAxis"


def warn_missing_unit(stage: Usd.Stage, notes: Substitutions) -> None:
    """Record that the stage has no unit."""
    if not stage.HasAuthoredMetadata(_METRES):
        notes.record(stage.GetPseudoRoot(), f"{_METRES} is not authored", "USD's fallback 0.01 is used", "author it")


def warn_layer_metrics(stage: Usd.Stage, notes: Substitutions) -> None:
    """Record, once for each layer, that its unit or up axis is not converted."""
    own = {_METRES: UsdGeom.GetStageMetersPerUnit(stage), _UP: str(UsdGeom.GetStageUpAxis(stage))}
    root = {stage.GetRootLayer(), stage.GetSessionLayer()}
    differing = {layer: _differing(layer, own) for layer in stage.GetUsedLayers() if layer not in root}
    strange = {layer: said for layer, said in differing.items() if said}
    if not strange:
        return
    for layer, prim in _introduced(stage, set(strange)):
        linear = np.array(UsdGeom.Xformable(prim).GetLocalTransformation(), np.float64)[:3, :3]
        scaled = not np.allclose(linear @ linear.T, np.eye(3), atol=1e-6)
        turned = not np.allclose(linear / max(float(np.linalg.norm(linear[0])), 1e-12), np.eye(3), atol=1e-6)
        said = strange[layer]
        name = layer.identifier.rpartition("/")[2]
        if _METRES in said and not scaled:
            factor = said[_METRES] / own[_METRES]
            reason = f"{name} has a unit of {said[_METRES]:g} m, and the stage one of {own[_METRES]:g} m"
            remedy = f"scale the prim by {factor:g}, if its sizes are wrong"
            notes.record(prim, reason, "USD takes its numbers as they are", remedy)
        if _UP in said and not turned:
            reason = f"{name} has {said[_UP]} up, and the stage {own[_UP]}"
            remedy = "rotate the prim by 90 degrees about X, if it lies"
            notes.record(prim, reason, "USD takes its axes as they are", remedy)


def _differing(layer: Sdf.Layer, own: dict[str, Any]) -> dict[str, Any]:
    """Return the authored metrics of a layer that differ from the stage's."""
    info = layer.pseudoRoot
    said = {name: info.GetInfo(name) for name in own if info.HasInfo(name)}
    return {name: value for name, value in said.items() if not _same(value, own[name])}


def _same(a: float | str, b: float | str) -> bool:
    return str(a) == str(b) if isinstance(a, str) or isinstance(b, str) else abs(a - b) <= 1e-6 * abs(b)


def _introduced(stage: Usd.Stage, layers: set[Sdf.Layer]) -> Iterator[tuple[Sdf.Layer, Usd.Prim]]:
    """Yield each layer with the first prim to which it contributes."""
    waiting = set(layers)
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if not waiting:
            return
        for layer in {spec.layer for spec in prim.GetPrimStack()} & waiting:
            waiting.discard(layer)
            yield layer, prim
