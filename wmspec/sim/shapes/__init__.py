"""Shapes, one file each, and the table of those in the language.

A new shape is a new file that implements `wmspec.sim.shapes.shape.Shape`, and a line in the table.
"""

from wmspec.sim.shapes.box import Box as Box
from wmspec.sim.shapes.box import Cube
from wmspec.sim.shapes.capsule import Capsule as Capsule
from wmspec.sim.shapes.cone import Cone as Cone
from wmspec.sim.shapes.cylinder import Cylinder as Cylinder
from wmspec.sim.shapes.extrude import Extrude as Extrude
from wmspec.sim.shapes.lathe import Lathe as Lathe
from wmspec.sim.shapes.mesh import Mesh as Mesh
from wmspec.sim.shapes.plane import Plane as Plane
from wmspec.sim.shapes.rounded import RoundedBox as RoundedBox
from wmspec.sim.shapes.shape import Shape as Shape
from wmspec.sim.shapes.sphere import Sphere as Sphere
from wmspec.sim.shapes.sweep import Sweep as Sweep
from wmspec.sim.shapes.torus import Torus as Torus
from wmspec.sim.shapes.tube import Tube as Tube
from wmspec.sim.shapes.wedge import Wedge as Wedge

#: Shapes by their word in the language.
SHAPES: dict[str, type[Shape]] = {
    "box": Box,
    "cube": Cube,
    "sphere": Sphere,
    "cylinder": Cylinder,
    "cone": Cone,
    "capsule": Capsule,
    "wedge": Wedge,
    "plane": Plane,
    "rounded_box": RoundedBox,
    "tube": Tube,
    "torus": Torus,
    "lathe": Lathe,
    "extrude": Extrude,
    "sweep": Sweep,
}


def shape_word(shape: Shape) -> str:
    """Return the word of a shape in the table."""
    return next(word for word, kind in SHAPES.items() if kind is type(shape))
