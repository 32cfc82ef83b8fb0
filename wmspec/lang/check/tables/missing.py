"""Words of things that the language lacks, for messages."""

from __future__ import annotations

#: Words of bodies that bend, flow or tear.
NOT_RIGID = frozenset(
    ("cloth", "textile", "towel", "sheet", "flag", "liquid", "fluid", "water", "oil", "milk", "juice", "honey", "gas",
     "smoke", "fire", "soft", "softbody", "soft_body", "deformable", "elastic", "jelly", "sponge", "foam", "dough",
     "stretch", "viscosity", "elasticity", "flexible", "granular", "balloon", "hair")
)  # fmt: skip
RIGID_REMEDY = "bodies are rigid: nothing bends, flows or tears; many small spheres can stand for what flows"
#: Libraries whose names are taken for shapes.
LIBRARY_SHAPES = frozenset(("rope",))
