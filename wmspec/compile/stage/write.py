"""Stages on disk: `base.usda` per task, `000000.usda` per instance over it, `000000.NAME.usda` per counterfactual.

Images are copied to `textures`, referenced files to `assets`, named by their content, so that a folder of stages can be
moved.
"""

from __future__ import annotations

from hashlib import blake2b
from pathlib import Path

from wmspec.compile.design.design import Design, Instance
from wmspec.compile.design.levels import format_levels
from wmspec.compile.design.what_ifs import what_ifs
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import base_layer, override_layer
from wmspec.core.limits import FILE_BYTES
from wmspec.core.safe_io import read_bytes, writing
from wmspec.lang.check.ir.ir import Counterfactual


def write_stages(design: Design, instance: Instance, folder: Path) -> list[Path]:
    """Write the base layer, and the layers of an instance and its counterfactuals, with images, to an existing folder.

    The base is the whole instance 0. Returns the paths of the layers. Raises WmsError if the folder is not writable.
    """
    spec = design.spec
    images: dict[str, Path] = {}

    def written(change: Counterfactual | None, of: Instance = instance) -> Document:
        return _with_local_files(document(spec, of, change), images)

    base, truth = written(None, design[0]), written(None)
    name = f"{instance.index:06d}"
    assigned = format_levels(spec.factors, instance.values)
    layers = {
        "base.usda": base_layer(base, f"{spec.title}. Instance 0; the layers of other instances change it."),
        f"{name}.usda": override_layer(
            base, truth, "./base.usda", f"{spec.name}, instance {instance.index}: {assigned}"
        ),
    }
    values, written_changes = Evaluator(spec, instance.values, None, instance.key), list[Counterfactual]()
    for question in spec.questions:
        for change in (*question.alternatives(instance.factors), *what_ifs(question, values)):
            target = ", ".join(change.levels) or f"{change.owner}{'.' if change.property else ''}{change.property}"
            what = f"What if: {change.name}, a change of {target}"
            file = f"{name}.{change.name}.usda"
            if file in layers and change in written_changes:  # of another question
                continue
            if file in layers:  # a counterfactual of another question has this name
                file = f"{name}.{spec.questions.index(question)}.{change.name}.usda"
            written_changes.append(change)
            layers[file] = override_layer(truth, written(change), f"./{name}.usda", what)
    for file, image in images.items():
        _write(folder / file, read_bytes(image, FILE_BYTES))
    return [_write(folder / file, layer.ExportToString().encode()) for file, layer in layers.items()]


def _with_local_files(made: Document, images: dict[str, Path]) -> Document:
    """Return the document with relative paths of images and assets; records their present paths in `images`."""
    for prim in made.prims.values():
        if prim.reference:
            here = _copy_name(Path(prim.reference), "assets")
            images[here] = Path(prim.reference)
            prim.reference = f"./{here}"
        for name, attribute in prim.attributes.items():
            if attribute.type == "asset":
                here = _copy_name(Path(attribute.value))
                images[here] = Path(attribute.value)
                prim.attributes[name] = attribute._replace(value=f"./{here}")
    return made


def _copy_name(image: Path, folder: str = "textures") -> str:
    """Return the name of a file's copy, determined by its content."""
    digest = blake2b(read_bytes(image, FILE_BYTES), digest_size=4).hexdigest()
    return f"{folder}/{image.stem}-{digest}{image.suffix.lower()}"


def _write(path: Path, content: bytes) -> Path:
    with writing(path):
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)
    return path
