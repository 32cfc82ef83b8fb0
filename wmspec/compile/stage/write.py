"""Stages on disk: `base.usda` per task, `000000.usda` per instance over it, `000000.NAME.usda` per counterfactual.

Images lie beside them in `textures`, what is referenced in `assets`, named by
their content, so that a folder of stages can be moved.
"""

from __future__ import annotations

from hashlib import blake2b
from pathlib import Path

from wmspec.compile.design.describe import told
from wmspec.compile.design.design import Design, Instance
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import base_layer, override_layer
from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.lang.check.ir.ir import Counterfactual


def write_stages(design: Design, instance: Instance, folder: Path) -> list[Path]:
    """Write the base layer, the instance's and its counterfactuals' into a folder that exists, and their images.

    The base is instance 0, whole. Returns the paths of the layers. Raises WmsError if the folder cannot be written to.
    """
    spec = design.spec
    images: dict[str, Path] = {}

    def written(change: Counterfactual | None, of: Instance = instance) -> Document:
        return _moved(document(spec, of, change), images)

    base, truth = written(None, design[0]), written(None)
    name = f"{instance.index:06d}"
    assigned = told(spec.factors, instance.values)
    layers = {
        "base.usda": base_layer(base, f"{spec.title}. Instance 0; the layers of other instances change it."),
        f"{name}.usda": override_layer(
            base, truth, "./base.usda", f"{spec.name}, instance {instance.index}: {assigned}"
        ),
    }
    for question in spec.questions:
        for change in question.alternatives(instance.factors):
            target = ", ".join(change.levels) or f"{change.owner}{'.' if change.property else ''}{change.property}"
            what = f"What if: {change.name}, a change of {target}"
            file = f"{name}.{change.name}.usda"
            if file in layers:  # another question has one of this name
                file = f"{name}.{spec.questions.index(question)}.{change.name}.usda"
            layers[file] = override_layer(truth, written(change), f"./{name}.usda", what)
    for file, image in images.items():
        _write(folder / file, image.read_bytes())
    return [_write(folder / file, layer.ExportToString().encode()) for file, layer in layers.items()]


def _moved(made: Document, images: dict[str, Path]) -> Document:
    """The document with its images and assets named relative to its own file; notes where they are now in `images`."""
    for prim in made.prims.values():
        if prim.reference:
            here = _name(Path(prim.reference), "assets")
            images[here] = Path(prim.reference)
            prim.reference = f"./{here}"
        for name, attribute in prim.attributes.items():
            if attribute.type == "asset":
                here = _name(Path(attribute.value))
                images[here] = Path(attribute.value)
                prim.attributes[name] = attribute._replace(value=f"./{here}")
    return made


def _name(image: Path, folder: str = "textures") -> str:
    """What the copy of a file is called: the same for the same bytes."""
    return f"{folder}/{image.stem}-{blake2b(image.read_bytes(), digest_size=4).hexdigest()}{image.suffix.lower()}"


def _write(path: Path, content: bytes) -> Path:
    try:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)
    except OSError as error:
        raise WmsError(f"cannot be written: {error.strerror}", FilePlace(str(path))) from None
    return path
