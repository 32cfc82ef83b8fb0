"""Twists that make a scene of `benchmarks/composed_stages.py` hostile, each mild or wild by chance."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from typing import Final

from benchmarks.composed_stages import ODD_FILES, ODD_NUMBERS, Plan, body, crate, package, usda

Twist = Callable[[Plan], None]


def _arc(made: Plan) -> str:
    return made.chance.choice(("references", "payload", "inherits", "specializes"))


# ---------------------------------------------------------------- composition


def cycle_of_layers(made: Plan) -> None:
    """Layers that are sublayers of one another."""
    made.layers |= {
        "one.usda": usda("", "subLayers = [@./two.usda@]"),
        "two.usda": usda("", f"subLayers = [@./{made.chance.choice(('one', 'root', 'two'))}.usda@]"),
    }
    made.sublayers.append("@./one.usda@")


def cycle_of_references(made: Plan) -> None:
    """Prims of two files that refer to one another, or to the root layer."""
    arc = made.chance.choice(("references", "payload"))
    back = made.chance.choice(("@./cycle_a.usda@", "@./root.usda@", "@./root.usda@</World>"))
    made.layers["cycle_a.usda"] = usda(f'def "a" ({arc} = @./cycle_b.usda@) {{ }}', 'defaultPrim = "a"')
    made.layers["cycle_b.usda"] = usda(f'def "b" ({arc} = {back}) {{ }}', 'defaultPrim = "b"')
    made.bodies.append(f'def "cycle" ({arc} = @./cycle_a.usda@) {{ }}')


def cycle_of_classes(made: Plan) -> None:
    """A class that inherits from itself, its child or its parent."""
    target = made.chance.choice(("</_c>", "</_c/x>", "</_c/x/y>", "</World>"))
    made.other.append(f'class "_c" ({_arc(made)} = {target}) {{ def "x" (inherits = </_c>) {{ def "y" {{ }} }} }}')
    made.bodies.append('def "inherits" (inherits = </_c>) { }')


def chain(made: Plan) -> None:
    """A long chain of arcs."""
    count, arc = made.chance.choice((20, 60, 150, 2_000)), _arc(made)
    made.other.append('class "L0" { def Sphere "end" { } }')
    made.other += [f'class "L{n}" ({arc} = </L{n - 1}>) {{ }}' for n in range(1, count)]
    made.bodies.append(f'def "chained" (inherits = </L{count - 1}>) {{ }}')


def doubling(made: Plan) -> None:
    """Prims that multiply with each level; as instances, they share their prototypes."""
    levels, width, arc = made.chance.choice((3, 6, 12, 40)), made.chance.choice((2, 5)), _arc(made)
    instance = made.chance.choice(("", "instanceable = true\n"))
    made.other.append('class "D0" { def Sphere "end" { } }')
    for n in range(1, levels):
        kids = " ".join(f'def "k{k}" ({instance}{arc} = </D{n - 1}>) {{ }}' for k in range(width))
        made.other.append(f'class "D{n}" {{ {kids} }}')
    made.bodies.append(f'def "doubled" (inherits = </D{levels - 1}>) {{ }}')


def many_layers(made: Plan) -> None:
    """A file under many names."""
    count = made.chance.choice((20, 300, 6_000))
    made.sublayers += [f"@./lights.usda:SDF_FORMAT_ARGS:n={n}@" for n in range(count)]


def deep(made: Plan) -> None:
    """Prims within prims."""
    count = made.chance.choice((20, 90, 300, 5_000))
    made.bodies.append('def "n" { ' * count + 'def Sphere "end" { }' + " }" * count)


def wide(made: Plan) -> None:
    """Many prims in a prim."""
    kind = made.chance.choice(("Xform", "Sphere", "Material", "Camera"))
    made.bodies += [f'def {kind} "w{n}" {{ }}' for n in range(made.chance.choice((100, 1_000, 10_000)))]


def variants(made: Plan) -> None:
    """Variant sets within variants, or with many variants."""
    levels, width = made.chance.choice(((3, 2), (40, 1), (1, 500), (6, 4)))
    text = ""
    for n in range(levels):
        one = f'(variantSets = "v{n - 1}"\nvariants = {{ string v{n - 1} = "a0" }})' if text else ""
        text = (
            f'variantSet "v{n}" = {{ {" ".join(f"{chr(34)}a{k}{chr(34)} {one} {{ {text} }}" for k in range(width))} }}'
        )
    made.bodies.append(
        f'def "varied" (variantSets = "v{levels - 1}"\nvariants = {{ string v{levels - 1} = "a0" }}) {{ {text} }}'
    )


def relocated(made: Plan) -> None:
    """Prims that move elsewhere, in a circle or into themselves."""
    moves = made.chance.choice(("</World/a>: </World/b>", "</World/a>: </World/a/b>", "</World/a>: </World/b>, "
                                "</World/b>: </World/a>", "</World>: </Moved>", "</World/ground>: <>"))  # fmt: skip
    made.head.append(f"relocates = {{ {moves} }}")
    made.other.append('class "_r" { def Sphere "a" { } }')


def offset(made: Plan) -> None:
    """A layer with shifted or scaled time."""
    number = made.chance.choice(ODD_NUMBERS)
    made.sublayers.append(f"@./lights.usda@ ({made.chance.choice(('offset', 'scale'))} = {number})")


def expression(made: Plan) -> None:
    """Variables that name one another, grow, or name what is no file."""
    kind = made.chance.randrange(5)
    count = made.chance.choice((5, 18, 40))
    if kind == 0:
        grown = {f"V{n}": f"`'${{V{n - 1}}}${{V{n - 1}}}'`" for n in range(1, count)}
        made.variables |= {"V0": "x", **grown, "FILE": f"`'${{V{count - 1}}}'`"}
    elif kind == 1:
        made.variables |= {"A": "`'${B}'`", "B": "`'${A}'`", "FILE": "`'${A}'`"}
    elif kind == 2:
        made.variables["FILE"] = made.chance.choice(
            ("`if(eq(1,1),'a','b')`", "`", "`${`", "`'${NONE}'`", "`" + "(" * 900)
        )
    else:
        made.variables["FILE"] = made.chance.choice(
            ("pipe", "../../secret", "/dev/zero", "lights", "absent", "x" * 9_000)
        )
    made.bodies.append('def "named" (references = @`"./${FILE}.usda"`@) { }')


def clips(made: Plan) -> None:
    """Value clips: templates with tiny strides, missing manifests, odd files and times."""
    number = made.chance.choice(ODD_NUMBERS)
    lines = [
        f"asset[] assetPaths = [@{made.chance.choice(ODD_FILES)}@]",
        f"asset manifestAssetPath = @{made.chance.choice((*ODD_FILES, './lights.usda'))}@",
        f'string primPath = "{made.chance.choice(("/World", "/Absent", "x y", ""))}"',
        f'string templateAssetPath = "{made.chance.choice(("./pipe.###.usda", "/dev/#", "./l#ghts.#.usda", "#"))}"',
        f"double templateStartTime = {made.chance.choice(('0', number))}",
        f"double templateEndTime = {made.chance.choice(('3', '1e12', number))}",
        f"double templateStride = {made.chance.choice(('1', '1e-9', number))}",
        f"double2[] active = [(0, {made.chance.choice(('0', '1e9', '-1'))})]",
        f"double2[] times = [(0, 0), ({number}, 1)]",
    ]
    chosen = made.chance.sample(lines, made.chance.randrange(1, len(lines)))
    made.bodies.append(
        f'def Sphere "clipped" (clips = {{ dictionary default = {{ {"; ".join(chosen)} }} }}) {{ double radius }}'
    )


def packed(made: Plan) -> None:
    """Packages with names that lead out, compressed members, packages inside, or themselves."""
    inner = usda(body(made, "ball"), 'defaultPrim = "ball"')
    out = usda("", f"subLayers = [@{made.chance.choice(('../root.usda', './packed.usdz', '/etc/passwd', 'x.usda'))}@]")
    first = made.chance.choice(("inner.usda", "../../out.usda", "/tmp/out.usda", "a/../../out.usda", "words.txt"))  # noqa: S108
    members = {first: made.chance.choice((inner, out)), "second.usda": inner}
    package(made, "packed.usdz", members, made.chance.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)))
    content = bytearray((made.folder / "packed.usdz").read_bytes())
    for _ in range(made.chance.choice((0, 0, 1, 8))):
        content[made.chance.randrange(len(content))] = made.chance.randrange(256)
    (made.folder / "packed.usdz").write_bytes(content)
    made.bodies.append(f'def "packed" (references = @./packed.usdz@{made.chance.choice(("", "</ball>"))}) {{ }}')
    made.root = made.chance.choice(("root.usda", "root.usda", "packed.usdz"))


def damaged(made: Plan) -> None:
    """A binary layer with damaged bytes."""
    text = usda(" ".join(body(made, f"ball{n}") for n in range(made.chance.choice((1, 40)))))
    crate(made, text, "damaged.usdc", made.chance.choice((0, 1, 4, 30)))
    made.bodies.append(
        f'def "damaged" ({made.chance.choice(("references", "payload"))} = @./damaged.usdc@</ball0>) {{ }}'
    )
    made.root = made.chance.choice(("root.usda", "root.usda", "damaged.usdc"))


def file(made: Plan) -> None:
    """A file that is odd or none."""
    name = made.chance.choice(ODD_FILES)
    if made.chance.random() < 0.3:
        made.sublayers.append(f"@{name}@")
    else:
        made.bodies.append(f'def "odd" ({made.chance.choice(("references", "payload"))} = @{name}@) {{ }}')


# ---------------------------------------------------------------- values


def number(made: Plan) -> None:
    """A number that no honest author writes."""
    odd = made.chance.choice(ODD_NUMBERS)
    attribute = made.chance.choice((
        f"float physics:mass = {odd}", f"float physics:density = {odd}", f"vector3f physics:velocity = ({odd}, 0, 0)",
        f"vector3f physics:angularVelocity = (0, {odd}, 0)", f"point3f physics:centerOfMass = (0, 0, {odd})",
        f"float3 physics:diagonalInertia = (1, {odd}, 1)", f"quatf physics:principalAxes = ({odd}, 0, 0, 0)",
        f"float3 xformOp:scale = (1, {odd}, 1); uniform token[] xformOpOrder = [\"xformOp:scale\"]",
        f"double xformOp:rotateZ = {odd}; uniform token[] xformOpOrder = [\"xformOp:rotateZ\"]",
        f"quatf xformOp:orient = ({odd}, 0, 0, 0); uniform token[] xformOpOrder = [\"xformOp:orient\"]",
    ))  # fmt: skip
    made.bodies.append(body(made, "odd_number", attribute))


def kind(made: Plan) -> None:
    """A value of another type than its schema has."""
    attribute = made.chance.choice((
        'string physics:mass = "heavy"', "float[] physics:mass = [1, 2]", "token physics:velocity = \"x\"",
        "asset physics:mass = @./root.usda@", "int physics:rigidBodyEnabled = 7", "double physics:mass = None",
        "custom rel physics:mass = </World>", "matrix4d xformOp:transform = ((0, 0, 0, 0), (0, 0, 0, 0), (0, 0, 0, 0), "
        '(0, 0, 0, 0)); uniform token[] xformOpOrder = ["xformOp:transform"]', "float physics:mass.timeSamples = { 0: 1, 1: 2 }",
        'uniform token[] xformOpOrder = ["xformOp:absent", "!resetXformStack!", "xformOp:absent"]', "unknown physics:mass = 1",
        "float physics:mass.connect = </World/absent.x>", "float physics:mass = 1; opaque x", "pathExpression x = \"//\"",
    ))  # fmt: skip
    made.bodies.append(body(made, "odd_kind", attribute))


def mesh(made: Plan) -> None:
    """A mesh whose arrays do not fit, or are large."""
    count = made.chance.choice((10, 10_000, 700_000))
    lines = made.chance.choice((
        "int[] faceVertexCounts = [3, -1, 2000000000]; int[] faceVertexIndices = [0, 1, 2]; point3f[] points = [(0, 0, 0)]",
        "int[] faceVertexCounts = [3]; int[] faceVertexIndices = [0, 1, 99999999]; point3f[] points = [(0, 0, 0)]",
        "int[] faceVertexCounts = [3]; int[] faceVertexIndices = [0, -5, 2]; point3f[] points = [(0, 0, 0), (1, 0, 0)]",
        "int[] faceVertexCounts = []; int[] faceVertexIndices = []; point3f[] points = []",
        "int[] faceVertexCounts = [3]; int[] faceVertexIndices = [0, 0, 0]; point3f[] points = [(nan, inf, 0)]",
        f"int[] faceVertexCounts = [{count}]; int[] faceVertexIndices = [{', '.join(['0'] * count)}]; point3f[] points = [(0, 0, 0)]",
        "int[] faceVertexCounts = [3]; int[] faceVertexIndices = [0, 1, 2]; point3f[] points = [(0, 0, 0), (1e30, 0, 0), (0, 1e-30, 0)]",
        "int[] holeIndices = [-1, 7]; int[] faceVertexCounts = [3]; int[] faceVertexIndices = [0, 1, 2]; point3f[] points = [(0, 0, 0), "
        "(1, 0, 0), (0, 1, 0)]; texCoord2f[] primvars:st = [(nan, 0)] (interpolation = \"faceVarying\"); int[] primvars:st:indices = [9]",
    ))  # fmt: skip
    solid = made.chance.choice(("", '(prepend apiSchemas = ["PhysicsCollisionAPI"])'))
    made.bodies.append(f'def Mesh "odd_mesh" {solid} {{ {lines} }}')


def joint(made: Plan) -> None:
    """A joint in a circle, to itself, to nothing, or with odd limits."""
    a, b = (
        made.chance.choice(("</World/body0>", "</World/ground>", "</World/absent>", "</World>", "<../x>")) for _ in "ab"
    )
    odd = made.chance.choice(ODD_NUMBERS)
    of = made.chance.choice(("Revolute", "Prismatic", "Fixed", "Spherical", "Distance", ""))
    made.bodies.append(
        f'def Physics{of}Joint "joint" {{ rel physics:body0 = {a}; rel physics:body1 = {b}; '
        f"float physics:lowerLimit = {odd}; float physics:upperLimit = {made.chance.choice(('1', '-1', 'nan'))}; "
        f'uniform token physics:axis = "{made.chance.choice(("X", "Q", ""))}"; quatf physics:localRot0 = ({odd}, 0, 0, 0) }}'
    )


def schema(made: Plan) -> None:
    """Schemas that are unknown, contradict, repeat or are many."""
    apis = made.chance.choice((["NoSuchAPI"], ["PhysicsArticulationRootAPI"] * 3, ["PhysicsLimitAPI:a:b:c"], ["PhysicsDriveAPI"],
                               [f"CollectionAPI:c{n}" for n in range(900)], ["MaterialBindingAPI", "PhysicsFilteredPairsAPI"]))  # fmt: skip
    listed = ", ".join(f'"{api}"' for api in apis)
    made.bodies.append(
        f'def {made.chance.choice(("Xform", "NoSuchType", "Sphere"))} "odd_schema" (apiSchemas = [{listed}]) {{ }}'
    )


def relation(made: Plan) -> None:
    """A relationship in a circle, into nothing, or deep."""
    target = made.chance.choice(
        ("</World/bound>", "</World/absent>", f"<{'/x' * 3_000}>", "</World/bound.x>", "<../..>")
    )
    name = made.chance.choice(
        ("material:binding", "physics:filteredPairs", "collection:c:includes", "physics:simulationOwner")
    )
    made.bodies.append(
        'def Sphere "bound" (prepend apiSchemas = ["MaterialBindingAPI", "PhysicsFilteredPairsAPI", "CollectionAPI:c", '
        f'"PhysicsCollisionAPI"]) {{ rel {name} = {target} }}'
    )


def texture(made: Plan) -> None:
    """A material with an odd image, or shaders in a circle."""
    image = made.chance.choice((*ODD_FILES, "../../secret.png"))
    source = made.chance.choice(
        ("</World/stuff/image.outputs:rgb>", "</World/stuff/shader.outputs:surface>", "</World/absent.x>")
    )
    made.bodies.append(
        'def Material "stuff" { token outputs:surface.connect = </World/stuff/shader.outputs:surface>; def Shader "shader" { '
        'uniform token info:id = "UsdPreviewSurface"; token outputs:surface; '
        f'color3f inputs:diffuseColor.connect = {source} }} def Shader "image" {{ uniform token info:id = "UsdUVTexture"; '
        f"asset inputs:file = @{image}@; float3 outputs:rgb }} }} "
        'def Cube "painted" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </World/stuff> }'
    )


def episode(made: Plan) -> None:
    """An episode or physics with odd numbers."""
    odd = made.chance.choice((*ODD_NUMBERS, "601", "1e-9"))
    if made.chance.random() < 0.5:
        made.episode = made.chance.choice((
            f"double wms:duration = {odd}", "double wms:duration = 0.05; int wms:rate = 2000000000", "double wms:duration = 500; int wms:rate = 999999",
            'double wms:duration = 0.05; string wms:task = "../../out"', "double wms:duration = 0.05; int wms:formatVersion = 99",
        ))  # fmt: skip
    else:
        made.gravity = made.chance.choice(
            (f"float physics:gravityMagnitude = {odd}", f"vector3f physics:gravityDirection = ({odd}, 0, 0)")
        )


def action(made: Plan) -> None:
    """An action or observation with odd parts."""
    odd = made.chance.choice(ODD_NUMBERS)
    verb = made.chance.choice(("launch", "move", "remove", "turn", "reach", "explode", ""))
    made.other.append(
        f'def WmsAction "act" {{ token wms:verb = "{verb}"; rel wms:object = {made.chance.choice(("</World/body0>", "</World>"))}; '
        f"double wms:start = {odd}; double wms:duration = {odd}; double wms:speed = {odd}; double3 wms:direction = ({odd}, 0, 0) }}"
    )
    times = made.chance.choice(("nan", "-1", "0, 1e9", ", ".join(["0.01"] * 20_000), "0"))
    made.other.append(f'def WmsObservation "see" {{ rel wms:camera = </World/eye>; double[] wms:times = [{times}] }}')
    made.bodies.append(f'def Camera "eye" {{ float focalLength = {made.chance.choice(("35", odd))} }}')


def metadata(made: Plan) -> None:
    """Units and other metadata of the stage that no honest author writes."""
    count = made.chance.choice((5, 60, 2_000))
    made.head.append(made.chance.choice((
        f"kilogramsPerUnit = {made.chance.choice(ODD_NUMBERS)}", f"timeCodesPerSecond = {made.chance.choice(ODD_NUMBERS)}",
        'customLayerData = { string x = "' + "x" * 10_000 * count + '" }', "startTimeCode = inf", 'comment = "\\x00"',
        "customLayerData = " + "{ dictionary d = " * count + "{ }" + " }" * count, 'owner = "\\n"', "framesPerSecond = nan",
    )))  # fmt: skip
    if made.chance.random() < 0.4:
        made.head[1:3] = [
            f"metersPerUnit = {made.chance.choice((*ODD_NUMBERS, '0.01'))}",
            f'upAxis = "{made.chance.choice("XYZQ")}"',
        ]


def samples(made: Plan) -> None:
    """Many time samples, or at odd times."""
    many = ", ".join(f"{n}: {n % 7}" for n in range(made.chance.choice((10, 100_000))))
    made.bodies.append(
        f'def Sphere "sampled" {{ double radius.timeSamples = {{ {made.chance.choice((many, "nan: 1", "1e308: 1, -1e308: 2"))} }} }}'
    )


def name(made: Plan) -> None:
    """Names that are long, not Latin, or like those of USD."""
    named = made.chance.choice(("x" * 20_000, "Ωmega", "__Prototype_1", "Episode", "World", "_", "con", "nul"))
    made.bodies.append(f'def Sphere "{named}" {{ }} over "{named}_" {{ }} def "{named}2" (active = false) {{ }}')


def text(made: Plan) -> None:
    """Damage to the text of the root layer."""
    made.other.append(
        made.chance.choice(("{" * 500, "(" * 3_000, "@", '"', "\0", "def", 'def "a" (' * 2_000, "'''", "[" * 9_000))
    )


TWISTS: Final[tuple[Twist, ...]] = (
    cycle_of_layers, cycle_of_references, cycle_of_classes, chain, doubling, many_layers, deep, wide, variants, relocated, offset,
    expression, clips, packed, damaged, file, number, kind, mesh, joint, schema, relation, texture, episode, action, metadata,
    samples, name, text,
)  # fmt: skip
