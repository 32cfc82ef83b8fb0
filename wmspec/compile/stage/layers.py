"""Documents as USD layers: a base layer per task and an override layer per instance, composed into a stage."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

import wmspec.sim.usd.schema  # noqa: F401  importing it registers the schemas, which must come before the first stage
from wmspec.compile.stage.document import Attribute, Document, Prim, Relation


def _singles(rows: Sequence[Sequence[float]], wide: int) -> NDArray[np.float32]:
    return np.array(rows, np.float32).reshape(-1, wide)


_VALUES: dict[str, Callable[[Any], Any]] = {
    "asset": Sdf.AssetPath,
    "double2": lambda v: Gf.Vec2d(*v),
    "double3": lambda v: Gf.Vec3d(*v),
    "float2": lambda v: Gf.Vec2f(*v),
    "float4": lambda v: Gf.Vec4f(*v),
    "point3f": lambda v: Gf.Vec3f(*v),
    "float3": lambda v: Gf.Vec3f(*v),
    "vector3f": lambda v: Gf.Vec3f(*v),
    "color3f": lambda v: Gf.Vec3f(*v),
    "quatd": lambda v: Gf.Quatd(*v),
    "quatf": lambda v: Gf.Quatf(*v),
    "quatd[]": lambda v: Vt.QuatdArray([Gf.Quatd(*q) for q in v]),
    "matrix4d": lambda v: Gf.Matrix4d(*(x for row in v for x in row)),
    "token[]": Vt.TokenArray,
    "double[]": Vt.DoubleArray,
    "double3[]": lambda v: Vt.Vec3dArray([Gf.Vec3d(*x) for x in v]),
    "float3[]": lambda v: Vt.Vec3fArray.FromNumpy(_singles(v, 3)),
    "int[]": Vt.IntArray,
    "point3f[]": lambda v: Vt.Vec3fArray.FromNumpy(_singles(v, 3)),
    "normal3f[]": lambda v: Vt.Vec3fArray.FromNumpy(_singles(v, 3)),
    "texCoord2f[]": lambda v: Vt.Vec2fArray.FromNumpy(_singles(v, 2)),
}


def base_layer(document: Document, doc: str = "", *, sources: bool = True) -> Sdf.Layer:
    """Return the whole document as an anonymous layer in metres, kilograms and Z up, optionally with `sources`."""
    layer = _layer(doc)
    with Sdf.ChangeBlock():
        for path, prim in document.prims.items():
            _define(layer, path, prim, sources)
    layer.GetPrimAtPath("/World").kind = "group"
    return layer


def override_layer(base: Document, document: Document, base_path: str, doc: str = "") -> Sdf.Layer:
    """Return the changes from the base to the document, over a sublayer at `base_path`."""
    layer = _layer(doc)
    layer.subLayerPaths.append(base_path)
    with Sdf.ChangeBlock():
        for path, prim in document.prims.items():
            if path not in base.prims:
                _define(layer, path, prim)
            else:
                _override(layer, path, base.prims[path], prim)
        for path in base.prims:
            if path not in document.prims:
                Sdf.CreatePrimInLayer(layer, path).SetInfo("active", False)
        _order(layer, base, document)
    return layer


def _order(layer: Sdf.Layer, base: Document, document: Document) -> None:
    """Set the order of children that the base lacks; otherwise they would come last."""
    before, after = _children(base), _children(document)
    for parent in before.keys() & after.keys():
        kept = [name for name in before[parent] if name in after[parent]]
        if kept != after[parent][: len(kept)]:
            Sdf.CreatePrimInLayer(layer, parent).nameChildrenOrder = after[parent]


def _children(document: Document) -> dict[str, list[str]]:
    children: dict[str, list[str]] = {}
    for path in document.prims:
        parent, _, name = path.rpartition("/")
        children.setdefault(parent, []).append(name)
    return {parent: names for parent, names in children.items() if parent}


def compose(document: Document, *, sources: bool = True) -> Usd.Stage:
    """Return an in-memory stage of the whole document; `sources` are optional for readers of scenes."""
    return Usd.Stage.Open(base_layer(document, sources=sources))


def without_geometry(stage: Usd.Stage, paths: Iterable[str]) -> Usd.Stage:
    """Remove the geometry below some prims of a stage; returns the stage."""
    for path in paths:
        every = Usd.PrimRange(stage.GetPrimAtPath(path)) if stage.GetPrimAtPath(path) else ()
        for prim in [prim for prim in every if prim.IsA(UsdGeom.Gprim)]:
            prim.SetActive(False)
    return stage


def _layer(doc: str) -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.defaultPrim = "World"
    root = layer.pseudoRoot
    for key, value in (("upAxis", "Z"), ("metersPerUnit", 1.0), ("kilogramsPerUnit", 1.0)):
        root.SetInfo(key, value)
    if doc:
        layer.documentation = doc
    return layer


def _define(layer: Sdf.Layer, path: str, prim: Prim, sources: bool = True) -> None:
    spec = Sdf.CreatePrimInLayer(layer, path)
    spec.specifier = Sdf.SpecifierDef
    spec.typeName = prim.type
    if prim.schemas:
        _apply(spec, prim.schemas)
    if prim.reference:
        spec.referenceList.prependedItems.append(Sdf.Reference(prim.reference))
    for name, attribute in prim.attributes.items():
        _attribute(spec, name, attribute, sources=sources)
    for name, relation in prim.relations.items():
        _relation(spec, name, relation, sources=sources)


def _override(layer: Sdf.Layer, path: str, before: Prim, after: Prim) -> None:
    attributes = {n: a for n, a in after.attributes.items() if not _same(before.attributes.get(n), a)}
    relations = {
        n: r for n, r in after.relations.items() if (b := before.relations.get(n)) is None or b.targets != r.targets
    }
    lost = before.attributes.keys() - after.attributes.keys()
    unrelated = before.relations.keys() - after.relations.keys()
    retyped, reapplied = before.type != after.type, before.schemas != after.schemas
    remade = before.reference != after.reference
    if not (attributes or relations or lost or unrelated or retyped or reapplied or remade):
        return
    spec = Sdf.CreatePrimInLayer(layer, path)
    if remade:
        spec.referenceList.ClearEditsAndMakeExplicit()
        spec.referenceList.explicitItems = [Sdf.Reference(after.reference)]
    if retyped:
        spec.typeName = after.type
    if reapplied:
        _apply(spec, after.schemas)
    for name, attribute in attributes.items():
        _attribute(spec, name, *_as_override(before.attributes.get(name), attribute))
    for name in sorted(lost):
        gone = before.attributes[name]
        _attribute(spec, name, gone._replace(value=Sdf.ValueBlock(), connection=""), bool(gone.connection))
        if (fallback := _fallback(after.type, after.schemas, name)) is not None:
            spec.attributes[name].default = fallback
    for name, relation in relations.items():
        _relation(spec, name, relation)
    for name in sorted(unrelated):
        _relation(spec, name, before.relations[name]._replace(targets=()))


@cache
def _fallback(type: str, schemas: tuple[str, ...], name: str) -> Any:
    """Return the schema's fallback of an attribute, if any; a value block would hide it."""
    registry = Usd.SchemaRegistry()
    known = registry.FindConcretePrimDefinition(type)
    whole = registry.BuildComposedPrimDefinition(type, list(schemas)) if known and schemas else known
    return whole.GetAttributeFallbackValue(name) if whole else None


def _as_override(before: Attribute | None, after: Attribute) -> tuple[Attribute, bool]:
    """Return the attribute as an override, and whether it ends a connection. A new connection hides the value."""
    if before is None or bool(before.connection) == bool(after.connection):
        return after, False
    return (after._replace(value=Sdf.ValueBlock()), False) if after.connection else (after, True)


def _same(a: Attribute | None, b: Attribute) -> bool:
    return a is not None and (a.type, a.value, a.connection) == (b.type, b.value, b.connection)


def _apply(spec: Sdf.PrimSpec, schemas: Iterable[str]) -> None:
    spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=list(schemas)))


def _attribute(
    spec: Sdf.PrimSpec, name: str, attribute: Attribute, disconnect: bool = False, *, sources: bool = True
) -> None:
    variability = Sdf.VariabilityUniform if attribute.uniform else Sdf.VariabilityVarying
    made = Sdf.AttributeSpec(spec, name, _type(attribute.type), variability)
    if attribute.value is not None:
        convert = _VALUES.get(attribute.type)
        blocked = isinstance(attribute.value, Sdf.ValueBlock)
        made.default = convert(attribute.value) if convert and not blocked else attribute.value
    if disconnect:
        made.connectionPathList.ClearEditsAndMakeExplicit()
    if attribute.connection:
        made.connectionPathList.explicitItems = [attribute.connection]
    if attribute.varies:
        made.SetInfo("interpolation", attribute.varies)
    if sources and attribute.sources:
        made.customData = {"wms": {"from": " ".join(sorted(attribute.sources))}}


@cache
def _type(name: str) -> Sdf.ValueTypeName:
    return Sdf.ValueTypeNames.Find(name)


def _relation(spec: Sdf.PrimSpec, name: str, relation: Relation, *, sources: bool = True) -> None:
    rel = Sdf.RelationshipSpec(spec, name, custom=False)
    rel.targetPathList.ClearEditsAndMakeExplicit()
    rel.targetPathList.explicitItems = list(relation.targets)
    if sources and relation.sources:
        rel.customData = {"wms": {"from": " ".join(sorted(relation.sources))}}
