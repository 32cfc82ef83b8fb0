"""What the language knows about the world: words, properties and settings, as tables.

Everything here is data: the checker reads it, and so do the messages and the reference documentation.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from wmspec.lang.check.types.types import (
    A_LENGTH,
    A_NUMBER,
    A_TIME,
    AN_ANGLE,
    COLLISION,
    COLOR,
    DIRECTION,
    MATERIAL,
    OBJECT,
    PLACE,
    POINT2,
    POINT3,
    ROBOT,
    SHAPE,
    TEXT,
    TRIPLE,
    TRUTH,
    TURNS,
    List,
    Quantity,
    Type,
    Vector,
)
from wmspec.lang.check.types.units import (
    ACCELERATION,
    ANGULAR_SPEED,
    DENSITY,
    INERTIA,
    MASS,
    NUMBER,
    SPEED,
    TIME,
    Dimension,
    told,
)
from wmspec.sim.materials import MATERIALS, SHADES
from wmspec.sim.shapes import SHAPES

#: sRGB in 0..1. Told apart at a glance, named as a person would name them.
COLORS: dict[str, tuple[float, float, float]] = {
    "red": (0.82, 0.17, 0.10),
    "orange": (0.94, 0.48, 0.05),
    "yellow": (0.92, 0.80, 0.12),
    "green": (0.21, 0.56, 0.31),
    "cyan": (0.10, 0.71, 0.80),
    "blue": (0.05, 0.25, 0.91),
    "purple": (0.49, 0.18, 0.61),
    "pink": (0.87, 0.54, 0.64),
    "brown": (0.40, 0.25, 0.15),
    "white": (0.95, 0.95, 0.93),
    "gray": (0.50, 0.50, 0.50),
    "black": (0.08, 0.08, 0.09),
    "oak": (0.68, 0.52, 0.36),
    "walnut": (0.40, 0.29, 0.21),
    "sand": (0.80, 0.76, 0.68),
    "slate": (0.46, 0.50, 0.54),
    "plaster": (0.74, 0.73, 0.71),
    "chalk": (0.90, 0.89, 0.87),
    "mist": (0.86, 0.90, 0.95),
}

#: How a mesh can be touched, and how UsdPhysics says that.
COLLISIONS = {
    "hull": "convexHull",
    "pieces": "convexDecomposition",
    "bounds": "boundingCube",
    "ball": "boundingSphere",
    "surface": "none",
}

WORDS: dict[str, tuple[str, ...]] = {
    "shape": tuple(SHAPES),
    "color": (*COLORS, *SHADES),
    "material": tuple(MATERIALS),
    "collision": tuple(COLLISIONS),
    "direction": ("left", "right", "away", "nearer"),
    "path": ("straight", "arc", "zigzag", "circle", "back_and_forth", "square", "triangle"),
    "relation": ("left_of", "right_of", "in_front_of", "behind", "above", "below"),
    "tie": ("neither",),
    "channel": ("rgb", "depth", "ids"),
}

#: Headings (rad) that words stand for, as a viewer at the front sees them: +x is right, +y is away.
HEADINGS = {"right": 0.0, "away": pi / 2, "left": pi, "nearer": -pi / 2}

#: The endings of the files that a property can name.
FILES = {
    "file": (".obj", ".stl", ".ply", ".off", ".glb", ".gltf", ".dae"),
    "image": (".png", ".jpg", ".jpeg"),
    "model": (".usdc", ".usda", ".usd"),
}

#: The endings of USD files, one mesh of which a property can name too: `thing.usda#/World/Cup`.
STAGES = (".usda", ".usd", ".usdc", ".usdz")

#: The endings of the files of assets, which `file` can name too: things of several links and joints.
ASSETS = (".urdf", ".xml", *STAGES)

#: Blocks that declare a set, and what its members are.
SETS = {"objects": "object", "joints": "joint"}

#: Kinds of joints, and what each lets an object do.
JOINTS = {
    "hinge": "turns about its axis",
    "slider": "slides along its axis",
    "ball": "turns every way about its place",
    "fixed": "holds it fast",
}


@dataclass(frozen=True)
class Slot:
    """A property or argument: the types it takes, its bounds, the value it has when left out, and what it means.

    `default` is the text of an expression; None means that it must be given unless `optional`. `among` are the words
    of the type that make sense here; all of them if it is empty.
    """

    types: tuple[Type, ...]
    meaning: str
    default: str | None = None
    optional: bool = False
    above: float | None = None
    least: float | None = None
    most: float | None = None
    nonzero: bool = False
    among: tuple[str, ...] = ()

    @property
    def dimension(self) -> Dimension:
        """That of its values, a plain number's if it takes none that has any."""
        return next((k.dimension for k in self.types if isinstance(k, Quantity | Vector)), NUMBER)

    def fault(self, value: float) -> str:
        """What a value must be and is not, such as `more than 0`; empty if it is within bounds."""
        if self.above is not None and value <= self.above:
            return f"more than {self._told(self.above)}"
        if self.least is not None and value < self.least:
            return f"at least {self._told(self.least)}"
        if self.most is not None and value > self.most:
            return f"at most {self._told(self.most)}"
        if self.nonzero and value == 0:
            return "other than 0"
        return ""

    def _told(self, bound: float) -> str:
        return told(bound, self.dimension) if bound else "0"


#: Properties that the material of an object decides when they are left out.
BY_MATERIAL = ("color", "roughness", "metallic")

#: What the parameters of shapes take.
PARAMETERS: dict[str, Type] = {
    "length": A_LENGTH,
    "number": A_NUMBER,
    "angle": AN_ANGLE,
    "points": List(POINT2),
    "path": List(POINT3),
}

#: The properties that only some shapes have, besides `radius` and `height`.
_OWN: dict[str, Slot] = {
    name: Slot((PARAMETERS[p.kind],), p.meaning, optional=True, above=p.above, least=p.least, most=p.most)
    for shape in SHAPES.values()
    for name, p in shape.properties.items()
}

#: The properties that say how large a shape is.
MEASURES = ("size", "radius", "height", *_OWN)

_FORM: dict[str, Slot] = {
    "shape": Slot((SHAPE,), "its form", "cube"),
    "size": Slot(
        (A_LENGTH, POINT3, POINT2), "edge or diameter and height; for a box or wedge, its three edges", "10 cm", above=0
    ),
    "radius": Slot((A_LENGTH,), "of a round object, instead of half its size", optional=True, above=0),
    "height": Slot((A_LENGTH,), "of a cylinder, cone or capsule, instead of its size", optional=True, above=0),
    **_OWN,
    "color": Slot((COLOR,), "its colour, which tints its material; instead of its material's own", optional=True),
    "material": Slot((MATERIAL,), "what it seems to be made of: its pattern and its gloss", "plastic"),
    "image": Slot((TEXT,), "a picture on its surface: a PNG or JPEG file beside the spec", optional=True),
    "repeats": Slot(
        (Vector(NUMBER, 2),),
        "how often the picture is repeated on a metre, or on what a mesh's own coordinates call 1; laid out once if left out",
        optional=True,
        above=0,
    ),
    "roughness": Slot(
        (A_NUMBER,), "of its surface, 0 is a mirror; instead of its material's", optional=True, least=0, most=1
    ),
    "metallic": Slot((A_NUMBER,), "1 for bare metal; instead of its material's", optional=True, least=0, most=1),
}
_MESH: dict[str, Slot] = {
    "file": Slot(
        (TEXT,),
        "a mesh beside the spec, instead of a shape: obj, stl, ply, off, glb, gltf, dae, or `thing.usda#/PRIM`",
        optional=True,
    ),
    "scale": Slot(
        (A_NUMBER, TRIPLE),
        "of the mesh, whose lengths are metres, along all of its axes or each; below 0 it is mirrored",
        "1",
        nonzero=True,
    ),
    "collision": Slot(
        (COLLISION,),
        "how a mesh is touched: as its hull, in convex pieces, as its upright box, as a ball around it, or, if it is fixed, as the surface that it is",
        "hull",
    ),
}
_TURN: dict[str, Slot] = {
    "yaw": Slot((AN_ANGLE,), "how far it is turned about the vertical, anticlockwise from above", "0 deg"),
    "pitch": Slot((AN_ANGLE,), "how far it is then tilted about its own y axis", "0 deg"),
    "roll": Slot((AN_ANGLE,), "how far it is then tilted about its own x axis", "0 deg"),
}

PROPERTIES: dict[str, dict[str, Slot]] = {
    "object": {
        **_FORM,
        **_MESH,
        "file": Slot((TEXT,), "a mesh (obj, stl, ply, off, glb, gltf, dae, or `thing.usda#/PRIM`) or an asset (urdf, xml, usd) beside the spec, instead of a shape", optional=True),
        "mass": Slot((Quantity(MASS),), "its mass, instead of its density", optional=True, above=0),
        "density": Slot((Quantity(DENSITY),), "its mass per volume", "600 kg/m^3", above=0),
        "centre": Slot((POINT3,), "its centre of mass, from its middle; instead of that of its form", optional=True),
        "moments": Slot((Vector(INERTIA, 3),), "its moments of inertia about that, along its own axes; instead of those of its form", optional=True, above=0),
        "axes": Slot((TURNS,), "how these axes are turned: yaw, pitch and roll", "(0, 0, 0)"),
        "friction": Slot((A_NUMBER,), "friction; a touching pair has the geometric mean", "0.5", least=0, most=5),
        "restitution": Slot((A_NUMBER,), "bounciness; a touching pair has the geometric mean", "0.1", least=0, most=1),
        "damping": Slot((Quantity(NUMBER / TIME),), "share of its speed that the air takes, per time", "0 Hz", least=0, most=100),
        "spin_damping": Slot((Quantity(NUMBER / TIME),), "share of its turning that the air takes, per time; as `damping` if left out", optional=True, least=0, most=100),
        "velocity": Slot((Vector(SPEED, 3),), "how fast it goes at the start, along the axes of the world", optional=True),
        "spin": Slot((Vector(ANGULAR_SPEED, 3),), "how fast it turns at the start, about the axes of the world", optional=True),
        "passes": Slot((List(OBJECT),), "the objects that it passes through", optional=True),
        "on": Slot((OBJECT,), "what it rests on; `on: table at (x, y)` says where, from its middle", optional=True),
        "inside": Slot((OBJECT,), "what it rests in: on the lowest part of it below the place", optional=True),
        "at": Slot((POINT2, POINT3, PLACE), "where its middle is: (x, y) on what it rests on or on the ground, or (x, y, z)", "(0 m, 0 m)"),
        "scatter": Slot((POINT2,), "the edges of a field around `at` in which its place is drawn", optional=True, least=0),
        "gap": Slot((A_LENGTH,), "the least distance from others that are scattered on the same thing", "1 cm", least=0),
        **_TURN,
        "fixed": Slot((TRUTH,), "whether it can never move", "false"),
        "solid": Slot((TRUTH,), "whether it can be touched; what cannot is a mark, fixed or carried by actions", "true"),
        "drawn": Slot((TRUTH,), "whether it can be seen; what only carries a camera need not be", "true"),
        "present": Slot((TRUTH,), "whether it is there at all", "true"),
        "called": Slot((TEXT,), "what texts call it, without article and colour: `\"crate\"`; else its shape, or its own name", optional=True),
        "plural": Slot((TEXT,), "what several of them are called, if that is not its name with an s", optional=True),
    },
    "part": {
        **_FORM,
        **_MESH,
        "at": Slot((POINT3,), "where its middle is, from the middle of the object's ground", "(0 m, 0 m, 0 m)"),
        **_TURN,
        "friction": Slot((A_NUMBER,), "its own, instead of that of its object", optional=True, least=0, most=5),
        "restitution": Slot((A_NUMBER,), "its own, instead of that of its object", optional=True, least=0, most=1),
        "solid": Slot((TRUTH,), "whether it can be touched; what cannot weighs nothing", optional=True),
        "drawn": Slot((TRUTH,), "whether it can be seen", optional=True),
    },
    "camera": {
        "at": Slot((POINT3,), "where it is"),
        "look_at": Slot((POINT3,), "what it looks at", "(0 m, 0 m, 0 m)"),
        "fov": Slot((AN_ANGLE,), "its vertical field of view", "40 deg", above=0, most=2.6),
        "far": Slot((A_LENGTH,), "how far it sees; 50 m if left out", optional=True, above=0, most=1000),
        "ride": Slot((OBJECT, ROBOT), "the object that carries it; then `at` and `look_at` are seen from there", optional=True),
    },
    "light": {
        "direction": Slot((TRIPLE,), "where its light goes", "(0.35, 0.45, -1)"),
        "diffuse": Slot((A_NUMBER,), "how much light comes from the sun", "0.65", least=0, most=2),
        "ambient": Slot((A_NUMBER,), "how much light comes from everywhere", "0.35", least=0, most=2),
        "shadows": Slot((TRUTH,), "whether things throw shadows in it; it shines through ceilings if they do not", "true"),
    },
    "world": {
        "gravity": Slot((Quantity(ACCELERATION),), "downwards", "9.81 m/s^2", least=0),
        "background": Slot((COLOR,), "what is seen where nothing is", "mist"),
    },
    "joint": {
        "of": Slot((OBJECT,), "the object that it moves"),
        "to": Slot((OBJECT,), "what that is joined to; the world if left out", optional=True),
        "at": Slot((POINT3,), "where it is in the world, at the start"),
        "axis": Slot((TRIPLE,), "of a hinge or slider, in the world, at the start", "(0, 0, 1)"),
        "low": Slot((AN_ANGLE, A_LENGTH), "its lower limit", optional=True),
        "high": Slot((AN_ANGLE, A_LENGTH), "its upper limit", optional=True),
        "start": Slot((AN_ANGLE, A_LENGTH), "of an asset's joint: where it is at the start", optional=True),
        "target": Slot((AN_ANGLE, A_LENGTH), "where its drive takes it", optional=True),
        "stiffness": Slot((A_NUMBER,), "of its drive, SI units per radian or metre", "0", least=0),
        "damping": Slot((A_NUMBER,), "of its drive, SI units", "0", least=0),
        "pace": Slot((A_NUMBER,), "the speed that its drive's damping keeps it at, SI units", optional=True),
        "strength": Slot((A_NUMBER,), "the most that its drive exerts, SI units; as much as it takes if left out", optional=True, above=0),
        "touching": Slot((TRUTH,), "whether the two that it joins can touch each other; they cannot if left out", optional=True),
        "present": Slot((TRUTH,), "whether it is there at all; it needs its objects", "true"),
    },
    "robot": {
        "on": Slot((OBJECT,), "what it stands on", optional=True),
        "at": Slot((POINT2, POINT3), "where it stands", "(0 m, 0 m)"),
        "yaw": Slot((AN_ANGLE,), "where it faces, anticlockwise from +x", "0 deg"),
        "color": Slot((COLOR,), "its colour", "white"),
        "model": Slot((TEXT,), "of an arm: the file that `wmspec arm` has made of it", optional=True),
        "roads": Slot((List(OBJECT),), "of a car: the objects that it drives on, which cross each other", optional=True),
        "lane": Slot((A_LENGTH,), "of a car: how wide the lanes of its roads are", "3.5 m", above=0),
        "keeps": Slot((DIRECTION,), "of a car: to which side of a road it keeps, `left` or `right`", "right", among=("left", "right")),
    },
}  # fmt: skip


SETTINGS: dict[str, Type] = {
    "title": TEXT,
    "license": TEXT,
    "source": TEXT,
    "repeat": A_NUMBER,
    "horizon": A_TIME,
}

#: What engines may disagree by.
TOLERANCES: dict[str, Slot] = {
    "rest": Slot((A_LENGTH,), "a body that has never moved", least=0),
    "drift": Slot((Quantity(SPEED),), "a body in motion that has met nothing yet, for each second of motion", least=0),
    "impact": Slot((A_NUMBER,), "after an impact: share of the speed with which the bodies met", least=0),
    "event": Slot((A_TIME,), "the first touch of two bodies", least=0),
    "angle": Slot((AN_ANGLE,), "the orientation of a body", least=0),
}


@dataclass(frozen=True)
class Form:
    """One way to write something, with an example of it."""

    written: str
    meaning: str


#: Domains of a factor, which is studied: separate values, all alike. A nuisance may be drawn from these too.
STUDIED = (
    Form("[red, blue]", "these values; objects, points, texts and truth values too"),
    Form("[0.5, 1, 2] m/s", "quantities of one unit"),
    Form("10 cm .. 20 cm by 5 cm", "steps from the start, up to the end"),
    Form("0 .. 1 in 5", "so many values at equal distances, with both ends"),
    Form("product([0 cm, 10 cm], [-5 cm, 5 cm])", "points with these coordinates; three lists for points in space"),
)

#: What a nuisance is drawn from, or a factor of a Latin hypercube.
SPREADS = (
    Form("-5 deg .. 5 deg", "anywhere between, all alike; `uniform(-5 deg, 5 deg)` is the same"),
    Form("log_uniform(100 g, 10 kg)", "anywhere between, all ratios alike"),
    Form("normal(0 deg, 2 deg)", "about a mean, with this standard deviation, cut off at three of them"),
)

#: What people call properties that have another name here.
OTHERWISE = {
    "weight": "mass",
    "colour": "color",
    "diameter": "size",
    "position": "at",
    "location": "at",
    "rotation": "yaw",
    "elasticity": "restitution",
    "bounciness": "restitution",
}

#: What people call words that are others here.
SYNONYMS = {
    "block": "box",
    "brick": "box",
    "disc": "cylinder",
    "disk": "cylinder",
    "pyramid": "cone",
    "ring": "torus",
    "pipe": "tube",
    "grey": "gray",
    "violet": "purple",
    "magenta": "pink",
    "turquoise": "cyan",
    "gold": "yellow",
}

#: What only a nuisance is drawn from.
WEIGHTED = (Form("weighted([red, blue], [3, 1])", "these values, the first three times as often"),)

#: What only a factor has.
CONDITIONAL = (Form("if shape == cube then [red, blue] else [green]", "values that depend on another factor"),)


@dataclass(frozen=True)
class Plan(Form):
    """A design; `counted` is one that says `of` how many instances."""

    counted: bool = False


#: Which combinations of the factors there are.
PLANS: dict[str, Plan] = {
    "factorial": Plan("design factorial", "all of them; the same if there is no `design`"),
    "sample": Plan("design sample of 500", "so many of them, the values of a factor equally often", counted=True),
    "latin": Plan("design latin of 200", "a Latin hypercube: factors may be intervals, covered evenly", counted=True),
    "groups": Plan(
        "design groups of 120 { cross: x  turn: [y] }",
        "so many control groups: in each some factors are crossed, all others are drawn anew for each group; `balance` "
        "keeps draws in which the answers of a question come equally often",
        counted=True,
    ),
    "one_at_a_time": Plan("design one_at_a_time { speed: 1 m/s }", "a baseline, and each factor varied by itself"),
}

#: Lengths above this (m) are taken for a mistake: engines lose precision there.
MOST_LENGTH = 1e4
