"""Small scenes that USD composes from many files, and the twists that make them hostile.

Without a twist a scene can be executed: a ground and one to four balls, boxes or meshes, each brought in by another arc
(reference, payload, class, variant, package, crate, expression, chain of references, instance). A twist changes one
thing that a hostile author may change, mildly or wildly. A scene is a pure function of its number.
"""

from __future__ import annotations

import random
import re
import struct
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

ODD_NUMBERS: Final = ("nan", "inf", "-inf", "-1", "0", "1e308", "-1e308", "1e-308", "1e39", "1e9")
ODD_FILES: Final = (
    "./pipe.usda", "./absent.usda", "./folder.usda", "./damaged.usdc", "/dev/zero", "/dev/tty", "/etc/passwd",
    "../../../../etc/passwd", "file:///etc/passwd", "http://localhost:1/x.usda", "anon:0x1:x.usda", "./empty.usda",
    f"./{'x' * 5_000}.usda", "./ö ü.usda", "./root.usda", "./packed.usdz[../root.usda]", "./packed.usdz[absent.usda]",
    "./root.usda:SDF_FORMAT_ARGS:a=1", ".", "", "./words.txt",
)  # fmt: skip
SHAPES: Final = (
    'def Sphere "shape" {{ double radius = {size} }}',
    'def Cube "shape" {{ double size = {size} }}',
    'def Mesh "shape" {{ int[] faceVertexCounts = [3, 3, 3, 3]; int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, '
    "0, 3, 2]; point3f[] points = [(0, 0, 0), ({size}, 0, 0), (0, {size}, 0), (0, 0, {size})]; "
    'uniform token subdivisionScheme = "none"; uniform token physics:approximation = "convexHull" }}',
)


def usda(text: str, head: str = "") -> str:
    """A layer; `;` and braces are put on lines of their own, as the text format needs."""
    lines = re.sub(r"\$\{\w*\}|[{}]|; ", lambda m: _LINES.get(m[0], m[0]), text)
    return f"#usda 1.0\n(\n{head}\n)\n{lines}\n"


_LINES = {"{": "{\n", "}": "\n}\n", "; ": "\n"}


@dataclass
class Plan:
    """A scene before it is written: texts of layers by file name, and the parts of the root layer."""

    chance: random.Random
    folder: Path
    layers: dict[str, str] = field(default_factory=dict)
    head: list[str] = field(default_factory=lambda: ['defaultPrim = "World"', "metersPerUnit = 1", 'upAxis = "Z"'])
    sublayers: list[str] = field(default_factory=lambda: ["@./lights.usda@"])
    variables: dict[str, str] = field(default_factory=dict)
    bodies: list[str] = field(default_factory=list)
    other: list[str] = field(default_factory=list)
    episode: str = "double wms:duration = 0.05"
    gravity: str = "float physics:gravityMagnitude = 9.81"
    root: str = "root.usda"
    twists: list[str] = field(default_factory=list)

    def write(self) -> Path:
        """Write all files; return the path of the root layer."""
        for name, text in self.layers.items():
            (self.folder / name).write_text(text)
        head = [*self.head, f"subLayers = [{', '.join(self.sublayers)}]"]
        if self.variables:
            lines = "\n".join(f'string {name} = "{value}"' for name, value in self.variables.items())
            head.append(f"expressionVariables = {{\n{lines}\n}}")
        text = (
            f'def WmsEpisode "Episode" {{ {self.episode} }} def PhysicsScene "Physics" {{ {self.gravity} }} '
            'def Xform "World" { def Cube "ground" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double size = 1; '
            "double3 xformOp:translate = (0, 0, -0.5); double3 xformOp:scale = (9, 9, 1); "
            'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"] } '
            f"{' '.join(self.bodies)} }} {' '.join(self.other)}"
        )
        (self.folder / "root.usda").write_text(usda(text, "\n".join(head)))
        return self.folder / self.root


# ---------------------------------------------------------------- what brings a body in


def body(made: Plan, name: str, physics: str = "float physics:mass = 1", kind: str = "def") -> str:
    """Return a rigid body with one shape."""
    apis = '"PhysicsRigidBodyAPI", "PhysicsMassAPI"'
    shape = made.chance.choice(SHAPES).format(size=made.chance.choice(("0.1", "0.2", "0.3")))
    solid = shape.replace('"shape" ', '"shape" (prepend apiSchemas = ["PhysicsCollisionAPI"]) ')
    return f'{kind} Xform "{name}" (prepend apiSchemas = [{apis}]) {{ {physics}; {solid} }}'


def _placed(made: Plan, name: str, at: str, arcs: str, inside: str = "") -> None:
    made.bodies.append(
        f'def Xform "{name}" ({arcs}) {{ double3 xformOp:translate = ({at}); '
        f'uniform token[] xformOpOrder = ["xformOp:translate"]; {inside} }}'
    )


def _layer(made: Plan, name: str, text: str) -> None:
    made.layers[f"{name}.usda"] = usda(text, f'defaultPrim = "{name}"')


def _referenced(made: Plan, name: str, at: str) -> None:
    _layer(made, name, body(made, name))
    arc, edit = made.chance.choice(("references", "payload")), made.chance.choice(("", "prepend ", "append ", "add "))
    _placed(made, name, at, f"{edit}{arc} = @./{name}.usda@{made.chance.choice(('', f'</{name}>'))}")


def _inherited(made: Plan, name: str, at: str) -> None:
    made.other.append(body(made, f"_{name}", kind="class"))
    _placed(made, name, at, f"{made.chance.choice(('inherits', 'specializes'))} = </_{name}>")


def _varied(made: Plan, name: str, at: str) -> None:
    _layer(made, name, body(made, name))
    arcs = 'variants = { string look = "one" }\nprepend variantSets = "look"'
    one = f'"one" (references = @./{name}.usda@) {{ }}'
    _placed(made, name, at, arcs, f'variantSet "look" = {{ {one} "two" {{ }} }}')


def _packed(made: Plan, name: str, at: str) -> None:
    package(made, f"{name}.usdz", {"inner.usda": usda(body(made, name), f'defaultPrim = "{name}"')})
    _placed(made, name, at, f"references = @./{name}.usdz{made.chance.choice(('', '[inner.usda]'))}@")


def _binary(made: Plan, name: str, at: str) -> None:
    crate(made, usda(body(made, name), f'defaultPrim = "{name}"'), f"{name}.usdc", 0)
    _placed(made, name, at, f"references = @./{name}.usdc@")


def _expressed(made: Plan, name: str, at: str) -> None:
    _layer(made, name, body(made, name))
    made.variables |= {"NAME": name[:4], f"N_{name}": f"`'${{NAME}}{name[4:]}'`"}
    _placed(made, name, at, f'references = @`"./${{N_{name}}}.usda"`@')


def _chained(made: Plan, name: str, at: str) -> None:
    count = made.chance.choice((2, 5, 20))
    made.other.append(body(made, f"{name}_0", kind="class"))
    made.other += [f'class "{name}_{n}" (references = </{name}_{n - 1}>) {{ }}' for n in range(1, count)]
    _placed(made, name, at, f"references = </{name}_{count - 1}>")


def _instanced(made: Plan, name: str, at: str) -> None:
    made.layers[f"{name}.usda"] = usda(
        f'def Xform "{name}" {{ {SHAPES[0].format(size="0.1")} }}', f'defaultPrim = "{name}"'
    )
    apis = 'prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]'
    look = f'def "look" (instanceable = true\nreferences = @./{name}.usda@) {{ }}'
    solid = 'def Cube "solid" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double size = 0.1 }'
    _placed(made, name, at, apis, f"float physics:mass = 1; {look} {solid}")


ARCS: Final[tuple[Callable[[Plan, str, str], None], ...]] = (
    _referenced, _inherited, _varied, _packed, _binary, _expressed, _chained, _instanced,
)  # fmt: skip


def crate(made: Plan, text: str, name: str, damages: int) -> None:
    """Write a binary layer, and overwrite bytes of it."""
    from pxr import Sdf

    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(text)
    layer.Export(str(made.folder / name))
    content = bytearray((made.folder / name).read_bytes())
    for _ in range(damages):
        at = made.chance.randrange(8, len(content) - 8)
        number = made.chance.choice((0, 2**62, 2**31, made.chance.getrandbits(60)))
        content[at : at + 8] = struct.pack("<Q", number)
    (made.folder / name).write_bytes(content)


def package(made: Plan, name: str, members: dict[str, str], method: int = zipfile.ZIP_STORED) -> None:
    """Write a package with its members at multiples of 64 bytes, as USD needs."""
    with zipfile.ZipFile(made.folder / name, "w", method) as package:
        assert package.fp is not None
        for member, text in members.items():
            entry = zipfile.ZipInfo(member)
            fill = -(package.fp.tell() + 30 + len(member.encode()) + 4) % 64
            entry.extra = struct.pack("<HH", 0x1986, fill) + bytes(fill)
            package.writestr(entry, text, method)
