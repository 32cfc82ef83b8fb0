"""Prims of an asset: their attributes, and where they are in metres with z up."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from wmspec.importers.markup import MOST
from wmspec.importers.model import Array, Faults

#: Columns of a transform may be so far from right angles (of 1).
_SKEW = 1e-6


class Prims:
    """Reads prims of one stage; what is wrong with them goes to the faults. `folder` is the spec's, if there is one."""

    def __init__(self, stage: Usd.Stage, shown: str, faults: Faults, folder: Path | None = None) -> None:
        self.stage = stage
        self.folder = folder
        self.shown = shown
        self.faults = faults
        self.meters = float(UsdGeom.GetStageMetersPerUnit(stage))
        self.kilograms = float(UsdPhysics.GetStageKilogramsPerUnit(stage))
        if not (0 < self.meters < MOST and 0 < self.kilograms < MOST):
            raise faults.stop(shown, "its units make no sense", "author metersPerUnit and kilogramsPerUnit above 0")
        self._cache = UsdGeom.XformCache()
        self._units = np.diag((self.meters, self.meters, self.meters, 1.0))
        if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y:
            self._units = np.array(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1))) @ self._units

    def where(self, prim: Usd.Prim) -> str:
        """How a prim is told."""
        return f"{self.shown}: `{prim.GetPath()}`"

    def value(self, prim: Usd.Prim, name: str, default: Any) -> Any:
        """The value of an attribute, or the default; complain about one that varies in time."""
        attribute = prim.GetAttribute(name)
        found = attribute.Get() if attribute else None
        if attribute and attribute.ValueMightBeTimeVarying():
            self.faults.add(self.where(prim), f"{name} varies in time", "remove its time samples")
        return default if found is None else found

    def number(self, prim: Usd.Prim, name: str, default: float, *, above: float = -math.inf) -> float:
        """A finite number; what is wrong is reported, and 1 is given for it."""
        found = float(self.value(prim, name, default))
        if not math.isfinite(found) or abs(found) > MOST or found <= above:
            self.faults.add(self.where(prim), f"{name} = {found:g} makes no sense", "correct it")
            return 1.0
        return found

    def world(self, prim: Usd.Prim) -> Array:
        """From the prim's own coordinates to metres with z up, 4 × 4."""
        for near in prim.GetPath().GetAncestorsRange():
            moved = UsdGeom.Xformable(self.stage.GetPrimAtPath(near))
            if moved and moved.TransformMightBeTimeVarying():
                self.faults.add(
                    self.where(prim), f"the transform of `{near}` varies in time", "remove its time samples"
                )
        return np.asarray(self._units @ np.array(self._cache.GetLocalToWorldTransform(prim)).T)

    def rigid(self, prim: Usd.Prim, *, skewed: bool = False) -> tuple[Array, Array]:
        """The prim's frame, 4 × 4, and how long (m) its units are along its axes (3,); complain if it is `skewed`.

        What may be skewed has the nearest frame that is not.
        """
        frame = self.world(prim)
        scale = np.linalg.norm(frame[:3, :3], axis=0)
        if not np.isfinite(frame).all() or (scale < 1e-9).any() or np.abs(frame).max() > MOST:
            self.faults.add(self.where(prim), "its transform is 0 or out of all proportion", "correct it")
            return np.eye(4), np.ones(3)
        made = frame.copy()
        made[:3, :3] /= scale
        if np.abs(made[:3, :3].T @ made[:3, :3] - np.eye(3)).max() > _SKEW:
            if not skewed:
                self.faults.add(self.where(prim), "its transform is skewed", "scale it along its own axes only")
            u, _, v = np.linalg.svd(made[:3, :3])
            made[:3, :3] = u @ v
        if np.linalg.det(made[:3, :3]) < 0:  # mirrored, which does nothing to what has a middle
            made[:3, 0] *= -1
        return made, scale

    @staticmethod
    def turn(quaternion: Any) -> Array:
        """The rotation (3, 3) of a quaternion of any length but 0."""
        q = np.array((quaternion.GetReal(), *quaternion.GetImaginary()), float)
        w, x, y, z = q / np.linalg.norm(q)
        return np.array(
            (
                (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
                (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
                (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
            )
        )
