"""Vocabulary of the language: words, properties and settings, as tables.

The checker, the messages and the reference documentation read these tables.
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
    INERTIA_SOURCE,
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
    UNITS,
    UP,
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
    format_quantity,
)
from wmspec.sim.materials import MATERIALS, SHADES
from wmspec.sim.shapes import SHAPES

#: sRGB in 0..1. Easily distinguished, with everyday names.
COLORS: dict[str, tuple[float, float, float]] = {
    "red": (0.78, 0.07, 0.06),
    "orange": (0.99, 0.51, 0.04),
    "yellow": (0.99, 0.92, 0.27),
    "green": (0.13, 0.55, 0.30),
    "cyan": (0.38, 0.81, 0.94),
    "blue": (0.10, 0.27, 0.95),
    "purple": (0.52, 0.11, 0.57),
    "pink": (0.97, 0.71, 0.78),
    "brown": (0.33, 0.21, 0.12),
    "white": (0.97, 0.97, 0.96),
    "gray": (0.46, 0.46, 0.46),
    "black": (0.06, 0.06, 0.07),
    "oak": (0.68, 0.52, 0.36),
    "walnut": (0.40, 0.29, 0.21),
    "sand": (0.80, 0.76, 0.68),
    "slate": (0.46, 0.50, 0.54),
    "plaster": (0.74, 0.73, 0.71),
    "chalk": (0.90, 0.89, 0.87),
    "mist": (0.86, 0.90, 0.95),
}

#: Collision approximations of meshes, and their UsdPhysics tokens.
COLLISIONS = {
    "hull": "convexHull",
    "pieces": "convexDecomposition",
    "bounds": "boundingCube",
    "ball": "boundingSphere",
    "surface": "none",
}

#: Length units of mesh files, in metres.
MESH_UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "inch": 0.0254, "foot": 0.3048}

#: Mesh formats whose standard has y up (glTF 2.0, section 3.4); in others z is up by default.
Y_UP = (".glb", ".gltf")

WORDS: dict[str, tuple[str, ...]] = {
    "shape": tuple(SHAPES),
    "color": (*COLORS, *SHADES),
    "material": tuple(MATERIALS),
    "collision": tuple(COLLISIONS),
    "units": tuple(MESH_UNITS),
    "up": ("x", "y", "z"),
    "inertia": ("file",),
    "direction": ("left", "right", "away", "nearer"),
    "path": ("straight", "arc", "zigzag", "circle", "back_and_forth", "square", "triangle"),
    "relation": ("left_of", "right_of", "in_front_of", "behind", "above", "below"),
    "tie": ("neither",),
    "channel": ("rgb", "depth", "ids"),
}

#: Headings (rad) of direction words, for a viewer at the front: +x is right, +y is away.
HEADINGS = {"right": 0.0, "away": pi / 2, "left": pi, "nearer": -pi / 2}

#: File extensions by property.
FILES = {
    "file": (".obj", ".stl", ".ply", ".off", ".glb", ".gltf", ".dae"),
    "image": (".png", ".jpg", ".jpeg"),
    "model": (".usdc", ".usda", ".usd"),
}

#: Extensions of USD files; a property can name one mesh of them: `thing.usda#/World/Cup`.
STAGES = (".usda", ".usd", ".usdc", ".usdz")

#: Extensions of asset files (several links and joints), which `file` can also name.
ASSETS = (".urdf", ".xml", *STAGES)

#: Blocks that declare a set, and the kind of its members.
SETS = {"objects": "object", "joints": "joint"}

#: Kinds of joints, and the motion that each allows.
JOINTS = {
    "hinge": "rotates about its axis",
    "slider": "slides along its axis",
    "ball": "rotates freely about its position",
    "fixed": "allows no motion",
}


@dataclass(frozen=True)
class PropertySpec:
    """A property or argument: accepted types, bounds, default, and meaning.

    `default` is the text of an expression; with None a value is required unless `optional`. `among` are the accepted
    words of the type; all of them if empty.
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
        """Dimension of its values; that of a plain number if they have none."""
        return next((k.dimension for k in self.types if isinstance(k, Quantity | Vector)), NUMBER)

    def violation(self, value: float) -> str:
        """Return the violated requirement, such as `more than 0`, or ''."""
        if self.above is not None and value <= self.above:
            return f"more than {self._format_bound(self.above)}"
        if self.least is not None and value < self.least:
            return f"at least {self._format_bound(self.least)}"
        if self.most is not None and value > self.most:
            return f"at most {self._format_bound(self.most)}"
        if self.nonzero and value == 0:
            return "other than 0"
        return ""

    def _format_bound(self, bound: float) -> str:
        return format_quantity(bound, self.dimension) if bound else "0"


#: Properties whose default depends on the material.
BY_MATERIAL = ("color", "roughness", "metallic")

#: Types of shape parameters.
PARAMETERS: dict[str, Type] = {
    "length": A_LENGTH,
    "number": A_NUMBER,
    "angle": AN_ANGLE,
    "points": List(POINT2),
    "path": List(POINT3),
}

#: Shape-specific properties, beyond `radius` and `height`.
_SHAPE_PARAMETERS: dict[str, PropertySpec] = {
    name: PropertySpec((PARAMETERS[p.kind],), p.meaning, optional=True, above=p.above, least=p.least, most=p.most)
    for shape in SHAPES.values()
    for name, p in shape.properties.items()
}

#: Properties that set the size of a shape.
MEASURES = ("size", "radius", "height", *_SHAPE_PARAMETERS)

_FORM: dict[str, PropertySpec] = {
    "shape": PropertySpec((SHAPE,), "form of the object or part", "cube"),
    "size": PropertySpec(
        (A_LENGTH, POINT3, POINT2),
        "edge length of a cube; diameter of a round shape, and also its height; a box or wedge has three lengths, a plane two",
        "10 cm",
        above=0,
    ),
    "radius": PropertySpec((A_LENGTH,), "radius of a round shape; default: half its `size`", optional=True, above=0),
    "height": PropertySpec(
        (A_LENGTH,), "height of a cylinder, cone or capsule; default: its `size`", optional=True, above=0
    ),
    **_SHAPE_PARAMETERS,
    "color": PropertySpec((COLOR,), "colour; replaces the material's own colour, and tints its pattern", optional=True),
    "material": PropertySpec((MATERIAL,), "look of the surface: pattern and gloss", "plastic"),
    "image": PropertySpec((TEXT,), "image on the surface: a PNG or JPEG file beside the spec", optional=True),
    "repeats": PropertySpec(
        (Vector(NUMBER, 2),),
        "repetitions of the image per metre, or per unit of a mesh's own texture coordinates; default: the image once",
        optional=True,
        above=0,
    ),
    "roughness": PropertySpec(
        (A_NUMBER,),
        "roughness of the surface (0: polished); default: the material's. Only the look `photo` draws reflections of the surroundings",
        optional=True,
        least=0,
        most=1,
    ),
    "metallic": PropertySpec(
        (A_NUMBER,), "1 for bare metal; default: the material's value", optional=True, least=0, most=1
    ),
}
_MESH: dict[str, PropertySpec] = {
    "file": PropertySpec(
        (TEXT,),
        "mesh that replaces the shape, in a file beside the spec: obj, stl, ply, off, glb, gltf, dae, or `thing.usda#/PRIM`",
        optional=True,
    ),
    "scale": PropertySpec(
        (A_NUMBER, TRIPLE),
        "scale of the mesh: one number, or one number for each axis; a negative number mirrors the mesh",
        "1",
        nonzero=True,
    ),
    "units": PropertySpec(
        (UNITS,), "unit of the mesh's lengths; default: metres, or the unit that a COLLADA file states", optional=True
    ),
    "up": PropertySpec(
        (UP,), "axis of the mesh that points up; default: y for files glb and gltf, z for others", optional=True
    ),
    "collision": PropertySpec(
        (COLLISION,),
        "collision shape of a mesh: its convex hull (`hull`), convex `pieces`, its upright bounding box (`bounds`), its bounding sphere (`ball`), or, only of a fixed object, its `surface`",
        "hull",
    ),
}
_TURN: dict[str, PropertySpec] = {
    "yaw": PropertySpec((AN_ANGLE,), "rotation about the vertical, anticlockwise as seen from above", "0 deg"),
    "pitch": PropertySpec((AN_ANGLE,), "rotation about its own y axis, after the yaw", "0 deg"),
    "roll": PropertySpec((AN_ANGLE,), "rotation about its own x axis, after yaw and pitch", "0 deg"),
}

PROPERTIES: dict[str, dict[str, PropertySpec]] = {
    "object": {
        **_FORM,
        **_MESH,
        "file": PropertySpec((TEXT,), "file beside the spec that replaces the shape: a mesh (obj, stl, ply, off, glb, gltf, dae, or `thing.usda#/PRIM`) or an asset (urdf, xml, usd)", optional=True),
        "strict": PropertySpec((TRUTH,), "whether wmspec refuses an asset file of which it cannot read everything exactly", optional=True),
        "inertia": PropertySpec((INERTIA_SOURCE,), "moments of inertia. With `inertia: file`, they are those of the asset file, even if no body of that mass and size can have them", optional=True),
        "mass": PropertySpec((Quantity(MASS),), "mass; replaces `density`", optional=True, above=0),
        "density": PropertySpec((Quantity(DENSITY),), "mass per volume", "600 kg/m^3", above=0),
        "centre": PropertySpec((POINT3,), "centre of mass, relative to the object's middle; default: that of its shape", optional=True),
        "moments": PropertySpec((Vector(INERTIA, 3),), "moments of inertia about the centre of mass, along `axes`; default: those of its shape", optional=True, above=0),
        "axes": PropertySpec((TURNS,), "rotation of the axes of `moments` in the object: yaw, pitch and roll", "(0, 0, 0)"),
        "friction": PropertySpec((A_NUMBER,), "coefficient of friction; a contact has the geometric mean of the two objects' coefficients", "0.5", least=0, most=5),
        "restitution": PropertySpec((A_NUMBER,), "coefficient of restitution; a contact has the geometric mean of the two objects' coefficients", "0.1", least=0, most=1),
        "damping": PropertySpec((Quantity(NUMBER / TIME),), "linear damping: the rate at which the speed decays", "0 Hz", least=0, most=100),
        "spin_damping": PropertySpec((Quantity(NUMBER / TIME),), "angular damping; default: the value of `damping`", optional=True, least=0, most=100),
        "velocity": PropertySpec((Vector(SPEED, 3),), "velocity at the start, in world axes", optional=True),
        "spin": PropertySpec((Vector(ANGULAR_SPEED, 3),), "angular velocity at the start, about world axes", optional=True),
        "surface_velocity": PropertySpec((Vector(SPEED, 3),), "of a fixed object that acts as a conveyor belt: velocity of its surface, in its own axes", optional=True),
        "passes": PropertySpec((List(OBJECT),), "objects with which it does not collide", optional=True),
        "on": PropertySpec((OBJECT,), "object on which it rests; `on: table at (x, y)` gives the place, relative to the middle of the table", optional=True),
        "inside": PropertySpec((OBJECT,), "object in which it rests, on the lowest of that object's parts at the place `at`", optional=True),
        "at": PropertySpec((POINT2, POINT3, PLACE), "place of its middle: (x, y) on its support or on the ground, or (x, y, z)", "(0 m, 0 m)"),
        "scatter": PropertySpec((POINT2,), "side lengths of the rectangle around `at` in which its place is drawn at random", optional=True, least=0),
        "gap": PropertySpec((A_LENGTH,), "smallest distance from other scattered objects on the same support", "1 cm", least=0),
        **_TURN,
        "fixed": PropertySpec((TRUTH,), "whether it never moves", "false"),
        "solid": PropertySpec((TRUTH,), "whether it collides; if not, it must be fixed or carried by actions", "true"),
        "drawn": PropertySpec((TRUTH,), "whether it is visible", "true"),
        "present": PropertySpec((TRUTH,), "whether it exists in the instance", "true"),
        "called": PropertySpec((TEXT,), "its noun in texts, without article and colour, such as `\"crate\"`; default: its shape or name", optional=True),
        "plural": PropertySpec((TEXT,), "plural of its noun, if it is not formed with an s", optional=True),
    },
    "part": {
        **_FORM,
        **_MESH,
        "at": PropertySpec((POINT3,), "place of its middle, relative to the middle of the bottom of the object", "(0 m, 0 m, 0 m)"),
        **_TURN,
        "friction": PropertySpec((A_NUMBER,), "value of this part; default: the value of the object", optional=True, least=0, most=5),
        "restitution": PropertySpec((A_NUMBER,), "value of this part; default: the value of the object", optional=True, least=0, most=1),
        "solid": PropertySpec((TRUTH,), "whether it collides; if not, it has no mass; default: `true`", optional=True),
        "drawn": PropertySpec((TRUTH,), "whether it is visible; default: `true`", optional=True),
    },
    "camera": {
        "at": PropertySpec((POINT3,), "position of the camera"),
        "look_at": PropertySpec((POINT3,), "point at which the camera looks", "(0 m, 0 m, 0 m)"),
        "fov": PropertySpec((AN_ANGLE,), "vertical field of view", "40 deg", above=0, most=2.6),
        "far": PropertySpec((A_LENGTH,), "largest visible distance; default: 50 m", optional=True, above=0, most=1000),
        "ride": PropertySpec((OBJECT, ROBOT), "object that carries the camera; `at` and `look_at` are then relative to that object", optional=True),
    },
    "light": {
        "direction": PropertySpec((TRIPLE,), "direction in which the light travels", "(0.35, 0.45, -1)"),
        "diffuse": PropertySpec((A_NUMBER,), "strength of the directed light", "0.4", least=0, most=2),
        "ambient": PropertySpec((A_NUMBER,), "strength of the ambient light", "0.6", least=0, most=2),
        "shadows": PropertySpec((TRUTH,), "whether objects cast shadows; if not, the light shines through ceilings", "true"),
    },
    "world": {
        "gravity": PropertySpec((Quantity(ACCELERATION),), "gravitational acceleration, downwards", "9.81 m/s^2", least=0),
        "background": PropertySpec((COLOR,), "colour where no object is seen", "mist"),
    },
    "joint": {
        "of": PropertySpec((OBJECT,), "the object that the joint moves"),
        "to": PropertySpec((OBJECT,), "the object to which it is joined; default: the world", optional=True),
        "at": PropertySpec((POINT3,), "position in the world at the start"),
        "axis": PropertySpec((TRIPLE,), "axis of a hinge or slider, in the world at the start", "(0, 0, 1)"),
        "low": PropertySpec((AN_ANGLE, A_LENGTH), "lower limit", optional=True),
        "high": PropertySpec((AN_ANGLE, A_LENGTH), "upper limit", optional=True),
        "start": PropertySpec((AN_ANGLE, A_LENGTH), "of an asset's joint: its coordinate at the start", optional=True),
        "target": PropertySpec((AN_ANGLE, A_LENGTH), "target of its drive", optional=True),
        "stiffness": PropertySpec((A_NUMBER,), "stiffness of its drive, N m/rad (hinge) or N/m (slider)", "0", least=0),
        "damping": PropertySpec((A_NUMBER,), "damping of its drive, N m s/rad (hinge) or N s/m (slider)", "0", least=0),
        "pace": PropertySpec((A_NUMBER,), "target speed of its drive, rad/s (hinge) or m/s (slider): `damping` acts on the difference from this speed", optional=True),
        "strength": PropertySpec((A_NUMBER,), "largest torque (N m) or force (N) of its drive; default: no limit", optional=True, above=0),
        "armature": PropertySpec((A_NUMBER,), "inertia that is added to the joint's coordinate, as by the rotor of a motor, kg m^2 (hinge) or kg (slider)", optional=True, least=0),
        "touching": PropertySpec((TRUTH,), "whether the two joined objects collide with each other; default: they do not", optional=True),
        "present": PropertySpec((TRUTH,), "whether it exists in the instance; if so, the objects that it joins must exist too", "true"),
    },
    "robot": {
        "on": PropertySpec((OBJECT,), "the object on which it stands", optional=True),
        "at": PropertySpec((POINT2, POINT3), "place where it stands", "(0 m, 0 m)"),
        "yaw": PropertySpec((AN_ANGLE,), "direction that it faces, anticlockwise from +x", "0 deg"),
        "color": PropertySpec((COLOR,), "colour", "white"),
        "model": PropertySpec((TEXT,), "of an arm: a file written by `wmspec import-arm`", optional=True),
        "roads": PropertySpec((List(OBJECT),), "of a car: the objects that are its roads, which may cross each other", optional=True),
        "lane": PropertySpec((A_LENGTH,), "of a car: width of the lanes of its roads", "3.5 m", above=0),
        "keeps": PropertySpec((DIRECTION,), "of a car: the side of the road on which it drives", "right", among=("left", "right")),
    },
}  # fmt: skip


SETTINGS: dict[str, Type] = {
    "title": TEXT,
    "license": TEXT,
    "source": TEXT,
    "repeat": A_NUMBER,
    "horizon": A_TIME,
}

#: Quantities in which engines may disagree.
TOLERANCES: dict[str, PropertySpec] = {
    "rest": PropertySpec((A_LENGTH,), "offset of a body that has not moved yet", least=0),
    "drift": PropertySpec((Quantity(SPEED),), "offset of a body for each second of its motion", least=0),
    "impact": PropertySpec(
        (A_NUMBER,), "offset for each second of motion after an impact, divided by the speed of the impact", least=0
    ),
    "event": PropertySpec((A_TIME,), "time of the first touch of two bodies", least=0),
    "angle": PropertySpec((AN_ANGLE,), "orientation of a body", least=0),
}


@dataclass(frozen=True)
class SyntaxForm:
    """A syntactic form: an example and its meaning."""

    written: str
    meaning: str


#: Domains of factors: separate, equally weighted values. Nuisances may use them too.
FACTOR_DOMAINS = (
    SyntaxForm("[red, blue]", "these values: words, objects, points, texts or truth values"),
    SyntaxForm("[0.5, 1, 2] m/s", "these quantities, in one unit"),
    SyntaxForm("10 cm .. 20 cm by 5 cm", "values in steps of 5 cm from 10 cm, at most 20 cm"),
    SyntaxForm("0 .. 1 in 5", "five equally spaced values, including both ends"),
    SyntaxForm(
        "product([0 cm, 10 cm], [-5 cm, 5 cm])",
        "all points (x, y) with an x of the first list and a y of the second; three lists give points in space",
    ),
)

#: Dimensions that a factor or nuisance may be `about`, with their meaning. The first five are those of the paper.
FACTOR_DIMENSIONS: dict[str, str] = {
    "color": "the colours of objects, and which object has which colour",
    "shape": "the shapes of objects, and which object has which shape",
    "size": "the sizes of objects and their ratios",
    "position": "where objects are, which way they face, and the side from which they come",
    "material": "the materials and surfaces of objects",
    "world": "the surroundings: place, style, light, camera, clutter",
    "other": "everything else: speeds, masses, times, numbers",
}

#: Clauses of a question: how each is written, and its meaning.
CLAUSES: dict[str, SyntaxForm] = {
    "answer": SyntaxForm("answer EXPRESSION", "measured on the executed episode"),
    "options": SyntaxForm(
        "options [A, B]", "possible answers; `options orbit of FACTORS` offers the pictures of a group"
    ),
    "ensure": SyntaxForm("ensure CONDITION", "rejects instances in which the condition does not hold"),
    "margin": SyntaxForm("margin VALUE apart by BOUND", "rejects instances that are too close to call"),
    "distinct": SyntaxForm("distinct by 5 cm", "rejects instances of which two options look alike"),
    "within": SyntaxForm("within 0.1 s", "the error up to which a number is right"),
    "hide": SyntaxForm("may hide OBJECTS", "these objects may be invisible in all pictures"),
    "seen": SyntaxForm(
        "seen OBJECTS at [0 s]", "these objects must be visible at these times, and may be hidden at others"
    ),
}
#: Words that stand alone in a clause, by the clause and the word.
CLAUSE_WORDS: dict[tuple[str, str], SyntaxForm] = {
    ("seen", "none"): SyntaxForm("seen none", "no object must be visible in any picture"),
    ("answer", "possible"): SyntaxForm(
        "answer possible", "whether the pictures show something that the laws of physics allow, or a violation of them"
    ),
}

#: What `legibility` of a question may be; without it, instances that are hard to read are rejected.
LEGIBILITY: dict[str, str] = {
    "off": "keeps instances that a person can hardly read off the pictures, for studies at the threshold of vision",
}

#: Continuous domains of nuisances, and of factors of a Latin hypercube.
CONTINUOUS_DOMAINS = (
    SyntaxForm("-5 deg .. 5 deg", "uniformly distributed over the interval; also written `uniform(-5 deg, 5 deg)`"),
    SyntaxForm("log_uniform(100 g, 10 kg)", "distributed over the interval so that the logarithm is uniform"),
    SyntaxForm(
        "normal(0 deg, 2 deg)",
        "normally distributed with this mean and standard deviation, truncated at three standard deviations",
    ),
)

#: Property names of other languages and their names here.
PROPERTY_ALIASES = {
    "weight": "mass",
    "colour": "color",
    "diameter": "size",
    "position": "at",
    "location": "at",
    "rotation": "yaw",
    "elasticity": "restitution",
    "bounciness": "restitution",
}

#: Synonyms of the dimensions of factors.
DIMENSION_ALIASES = {
    "colour": "color",
    "hue": "color",
    "form": "shape",
    "location": "position",
    "place": "position",
    "orientation": "position",
    "texture": "material",
    "background": "world",
    "scene": "world",
    "light": "world",
    "camera": "world",
    "nothing": "other",
}

#: Synonyms of words.
WORD_ALIASES = {
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

#: Domains for nuisances only.
WEIGHTED_DOMAINS = (
    SyntaxForm(
        "weighted([red, blue], [3, 1])",
        "these values with these weights: here, red is drawn three times as often as blue",
    ),
)

#: Domains for factors only.
CONDITIONAL_DOMAINS = (
    SyntaxForm(
        "if shape == cube then [red, blue] else [green]", "one of two lists of values, depending on another factor"
    ),
)


@dataclass(frozen=True)
class DesignForm(SyntaxForm):
    """A design; with `counted`, `of` gives the number of instances."""

    counted: bool = False


#: Designs: the combinations of factors.
DESIGNS: dict[str, DesignForm] = {
    "factorial": DesignForm("design factorial", "every combination of levels; the default"),
    "sample": DesignForm(
        "design sample of 500",
        "500 random combinations, in which the values of each factor are equally frequent",
        counted=True,
    ),
    "latin": DesignForm(
        "design latin of 200",
        "a Latin hypercube of 200 combinations. A factor may also be an interval; the combinations cover it evenly",
        counted=True,
    ),
    "groups": DesignForm(
        "design groups of 120 { cross: x  turn: [y] }",
        "120 control groups. Within a group, all factors of `cross` vary, and so does one factor of `turn`. All other "
        "factors have one value in each group, which is drawn at random. With a clause `balance`, wmspec keeps those draws in "
        "which the answers of a question are equally frequent",
        counted=True,
    ),
    "one_at_a_time": DesignForm(
        "design one_at_a_time { speed: 1 m/s }",
        "a baseline (here, with a `speed` of 1 m/s), and all instances that differ from it in one factor",
    ),
}

#: Maximum length (m): engines lose precision beyond it.
MAX_LENGTH = 1e4

#: Words of bodies that bend, flow or tear.
NOT_RIGID = frozenset(
    ("cloth", "textile", "towel", "sheet", "flag", "liquid", "fluid", "water", "oil", "milk", "juice", "honey", "gas",
     "smoke", "fire", "soft", "softbody", "soft_body", "deformable", "elastic", "jelly", "sponge", "foam", "dough",
     "stretch", "viscosity", "elasticity", "flexible", "granular", "balloon", "hair")
)  # fmt: skip
RIGID_REMEDY = "bodies are rigid: nothing bends, flows or tears; many small spheres can stand for what flows"
#: Libraries whose names are taken for shapes.
LIBRARY_SHAPES = frozenset(("rope",))
