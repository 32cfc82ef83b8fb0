"""Stages on disk: `base.usda` per task, `000000.usda` per instance over it, `000000.NAME.usda` per counterfactual."""

from __future__ import annotations

from pathlib import Path

from pxr import Sdf

from wmspec.design.design import Design, Instance
from wmspec.errors import WmsError
from wmspec.stage.episode import document
from wmspec.stage.layers import base_layer, override_layer


def write_stages(design: Design, instance: Instance, folder: Path) -> list[Path]:
    """Write the base layer, the instance's and its counterfactuals' into a folder that exists; returns their paths.

    The base is instance 0, whole. Raises WmsError if the folder cannot be written to.
    """
    spec = design.spec
    base, truth = document(spec, design[0]), document(spec, instance)
    name = f"{instance.index:06d}"
    assigned = ", ".join(f"{k} = {v:g}" if isinstance(v, float) else f"{k} = {v}" for k, v in instance.values.items())
    layers = {
        "base.usda": base_layer(base, f"{spec.title}. Instance 0; the layers of other instances change it."),
        f"{name}.usda": override_layer(
            base, truth, "./base.usda", f"{spec.name}, instance {instance.index}: {assigned}"
        ),
    }
    for question in spec.questions:
        for change in question.counterfactuals:
            what = (
                f"What if: {change.name}, a change of {change.owner}{'.' if change.property else ''}{change.property}"
            )
            altered = document(spec, instance, change)
            layers[f"{name}.{change.name}.usda"] = override_layer(truth, altered, f"./{name}.usda", what)
    return [_export(layer, folder / file) for file, layer in layers.items()]


def _export(layer: Sdf.Layer, path: Path) -> Path:
    try:
        path.write_text(layer.ExportToString(), encoding="utf-8")
    except OSError as error:
        raise WmsError(f"{path}: cannot be written: {error.strerror}") from None
    return path
