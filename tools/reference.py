"""Generate the pages of docs/reference from the tables of the checker.

python tools/reference.py            writes the pages
python tools/reference.py --check    exits with 1 if a page is not current
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path

from pxr import Sdf

from wmspec.lang.check.expressions.calls import signature
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.tables.property_schema import APPEARANCE, allowed_properties, entity_type
from wmspec.lang.check.tables.verbs import ROBOTS, VERBS, Verb
from wmspec.lang.check.tables.vocabulary import (
    CONDITIONAL_DOMAINS,
    CONTINUOUS_DOMAINS,
    DESIGNS,
    FACTOR_DIMENSIONS,
    FACTOR_DOMAINS,
    JOINTS,
    PROPERTIES,
    SETTINGS,
    TOLERANCES,
    WEIGHTED_DOMAINS,
    WORDS,
    PropertySpec,
    SyntaxForm,
)
from wmspec.lang.check.types.types import either
from wmspec.lang.check.types.units import EXAMPLES, UNITS
from wmspec.lang.parse.codes import CODES
from wmspec.runtime.questions.legibility.bounds import BOUNDS, REFERENCE_SIDE
from wmspec.sim.materials import MATERIALS
from wmspec.sim.usd import schema

FOLDER = Path(__file__).parent.parent / "docs/reference"
#: A verb, the bodies that it accepts, and its effect, in the documentation of `wms:verb`.
VERB_LINE = re.compile(r"(\w+) \((.*?)\): (.*)\.")
#: File, title and sections of each page.
PAGES = (
    ("designs", "Domains and designs", ("Domains", "Dimensions", "Designs")),
    ("properties", "Properties", ("Properties", "Joints", "Materials")),
    ("verbs", "Verbs", ("Verbs", "Robots")),
    ("functions", "Functions", ("Functions",)),
    ("units", "Units, words and tolerances", ("Units", "Words", "Settings", "Tolerances")),
    ("diagnostics", "Diagnostics", ("Codes",)),
    ("legibility", "Legibility", ("Measures",)),
    ("episode_prims", "Prims of an episode", ("WmsEpisode", "WmsAction", "Verbs of a WmsAction", "WmsObservation")),
)


def pages() -> dict[Path, str]:
    """Return the text of each page by its path."""
    whole = "\n".join(chain(reference(), measures(), schemas())).removeprefix("### ")
    sections = dict(section.split("\n", 1) for section in whole.split("\n### "))
    made = {}
    for name, title, parts in PAGES:
        text = f"# {title}\n\n`make generate` writes this page from the implementation.\n"
        for part in parts:
            heading = f"\n## {part}\n" if len(parts) > 1 else ""
            text += f"{heading}\n{sections.pop(part).strip()}\n"
        made[FOLDER / f"{name}.md"] = text
    assert not sections, f"on no page: {', '.join(sections)}"
    return made


def reference() -> Iterator[str]:
    """Yield the lines of the reference."""
    yield from design()
    yield from entities()


def design() -> Iterator[str]:
    """Yield the tables of factors and designs."""
    yield "### Domains\n"
    yield "A `factor` or a `nuisance` may have these domains of constants:\n"
    yield from forms("domain", FACTOR_DOMAINS)
    yield "A `nuisance`, or a `factor` of a Latin hypercube, may have these:\n"
    yield from forms("domain", CONTINUOUS_DOMAINS)
    yield "Only a `nuisance` may have these:\n"
    yield from forms("domain", WEIGHTED_DOMAINS)
    yield "Only a `factor` may have these:\n"
    yield from forms("domain", CONDITIONAL_DOMAINS)
    yield "### Dimensions\n"
    yield "`about` states what a `factor` or `nuisance` changes: `factor tone in [red, blue] about color`.\n"
    yield from table(("dimension", "meaning"), ((f"`about {name}`", what) for name, what in FACTOR_DIMENSIONS.items()))
    yield "### Designs\n"
    yield from forms("design", DESIGNS.values())


def entities() -> Iterator[str]:
    """Yield the tables of objects, actions, functions, words and codes."""
    yield "### Properties\n"
    yield (
        'Limits are in SI units, so those of angles are in radians. The default "—" means: no value, '
        "unless the last column states a default.\n"
    )
    for kind, properties in PROPERTIES.items():
        yield f"Properties of {'the world' if kind == 'world' else f'{article(kind)} {kind}'}:\n"
        yield from table(
            ("property", "values", "default", "meaning"),
            (
                row(name, slot, "its object's" if kind == "part" and name in APPEARANCE else "")
                for name, slot in properties.items()
            ),
        )
    yield "### Joints\n"
    yield "Every engine executes all kinds of joints. [The stage](../stage.md) describes them in detail.\n"
    yield from table(("joint", "meaning", "coordinate", "properties that not all kinds have"), joints())
    yield "### Verbs\n"
    yield (
        'Limits are in SI units, so those of angles are in radians. An argument with the default "—" may be absent. '
        "An action whose verb ends in `for TIME` needs a duration.\n"
    )
    for name, verb in VERBS.items():
        yield from described(name, verb)
    yield "### Robots\n"
    yield (
        "wmspec plans the motion of a robot when it compiles the stage: see [robots](../robots.md). Limits are in SI "
        "units, so those of angles are in radians.\n"
    )
    for verbs in {id(each): each for each in ROBOTS.values()}.values():
        models = [model for model, can in ROBOTS.items() if can is verbs]
        yield " or ".join(f"{'an' if model[0] in 'aeiou' else 'a'} `{model}`" for model in models).capitalize() + ":\n"
        calls = (
            (f"`{call(name, verb)}`", verb.meaning, "<br>".join(arguments(verb)) or "—") for name, verb in verbs.items()
        )
        yield from table(("verb", "meaning", "arguments"), calls)
    yield "### Functions\n"
    for measured in (False, True):
        lines = (
            "These functions measure the executed episode. They are allowed in `answer`, `ensure`, `margin` and "
            "`difference`. The *window* lasts from the first observed picture to the last. A *span* lasts `from` "
            "a time `to` a time. *At the end* means at the end of the episode, and *at a time* means at the time `at`. "
            "[Measures](../questions.md#measures) defines each function:"
            if measured
            else "A plain number has no unit. Arguments with a name, such as `seen_from: camera or object`, are "
            "optional. A function with the argument `tie` returns `neither` if another object comes close to the "
            "chosen one: with `tie: 1.1`, if their values differ by a factor below 1.1; with `tie: 0.1 s`, if their "
            "times differ by less than 0.1 s.\n\nThese functions are allowed in every expression:"
        )
        yield f"{lines}\n"
        chosen = ((n, f) for n, f in FUNCTIONS.items() if bool(f.measured) == measured)
        rows = ((f"`{signature(n, f)}`", str(f.result), f.meaning) for n, f in chosen)
        yield from table(("function", "result", "meaning"), rows)
    yield "### Settings\n"
    kinds = ", ".join(f"`{name}` ({kind})" for name, kind in SETTINGS.items())
    yield f"A task has each of these settings at most once: {kinds}.\n"
    yield "`repeat` is the number of times that the design occurs, and `horizon` the length of an episode.\n"
    yield "### Tolerances\n"
    limits = ((f"`{name}`", str(slot.types[0]), slot.meaning) for name, slot in TOLERANCES.items())
    yield (
        "A tolerance is the largest difference between engines that counts as agreement. A task sets one with a line "
        "such as `tolerance event 30 ms`. [Crosscheck](../crosscheck.md#tolerances) has the defaults.\n"
    )
    yield from table(("tolerance", "value", "applies to"), limits)
    yield "### Materials\n"
    yield (
        "A material sets only the look of an object; `density`, `friction` and `restitution` set its mechanics. An "
        "object without `color` has the colour (sRGB) of its material.\n"
    )
    looks = (
        (f"`{n}`", m.meaning, ", ".join(f"{c:g}" for c in m.color), f"{m.roughness:g}", f"{m.metallic:g}")
        for n, m in MATERIALS.items()
    )
    yield from table(("material", "look", "color", "roughness", "metallic"), looks)
    yield "### Words\n"
    yield "A value of one of these types is one of the words behind it:\n"
    for vocabulary, words in (WORDS | {"kind of joint": JOINTS}).items():
        yield f"- **{vocabulary}**: {', '.join(f'`{word}`' for word in words)}"
    yield "\n### Units\n"
    units = (
        (f"`{name}`", str(dimension), f"{scale:.6g} {dimension.symbol}".strip())
        for name, (scale, dimension) in UNITS.items()
    )
    yield from table(("unit", "quantity", "in SI"), units)
    yield (
        "Examples of quantities: " + ", ".join(f"{dimension} `{text}`" for dimension, text in EXAMPLES.items()) + ".\n"
    )
    yield "### Codes\n"
    yield "Every error and warning of `wmspec check` has a code. `wmspec explain CODE` explains it, with an example.\n"
    yield from table(("code", "meaning"), ((f"`{code}`", meaning) for code, meaning in CODES.items()))


def measures() -> Iterator[str]:
    """Yield the measures of legibility with their bounds and sources."""
    yield "### Measures\n"
    yield (
        "These measures state how well a person can see what decides the answer to a question. wmspec rejects a "
        "question that violates a bound. [Questions](../questions.md#legibility) explains how wmspec measures, and "
        "which measures apply.\n"
    )
    side = REFERENCE_SIDE
    yield (
        f"`px` are pixels of a picture of {side} x {side}; wmspec scales lengths in pictures of other sizes to that. "
        "The bounds assume that a picture fills 10 degrees of the visual field, such as 10 cm at a distance of 57 cm. "
        f"So a pixel is {600 / side:.1f} arc minutes wide.\n"
    )
    limits = (
        (f"`{name}`", f"at {'most' if b.at_most else 'least'} {b.value:g} {b.unit}".strip(), b.meaning, b.source)
        for name, b in BOUNDS.items()
    )
    yield from table(("measure", "bound", "meaning", "source"), limits)


def schemas() -> Iterator[str]:
    """Yield the sections of the USD schemas; the documentation of `wms:verb` has a line for each verb."""
    layer = Sdf.Layer.FindOrOpen(str(Path(schema.__file__).parent / "generatedSchema.usda"))
    for kind in ("WmsEpisode", "WmsAction", "WmsObservation"):
        prim = layer.GetPrimAtPath(f"/{kind}")
        yield f"### {kind}\n"
        yield f"{prim.GetInfo('documentation')}\n"
        if kind == "WmsAction":
            yield "A property whose meaning begins with *Of a* and a verb belongs to actions with this verb only.\n"
        documented = {one.name: one.GetInfo("documentation") for one in prim.properties}
        verbs = documented.get("wms:verb", "").splitlines()
        rows = ((f"`{one.name}`", _type(one), _code(documented[one.name])) for one in prim.properties)
        yield from table(("property", "type", "meaning"), (row for row in rows if row[0] != "`wms:verb`"))
        if verbs:
            yield "### Verbs of a WmsAction\n"
            yield "`wms:verb` (token) is one of:\n"
            yield from table(("verb", "accepted bodies", "effect"), map(_verb, verbs))


def _verb(line: str) -> tuple[str, ...]:
    """Return a row of the table of verbs. Raises ValueError for a line of another form."""
    if (part := VERB_LINE.fullmatch(line)) is None:
        raise ValueError(f"expected `verb (bodies): effect.`, found {line!r}")
    return f"`{part[1]}`", _code(part[2]), _code(part[3])


def _type(one: Sdf.PropertySpec) -> str:
    """Return the type of an attribute, or `rel` of a relationship."""
    return str(one.typeName) if isinstance(one, Sdf.AttributeSpec) else "rel"


def _code(text: str) -> str:
    """Return a text with its names of properties as code."""
    return re.sub(r"wms:\w+", r"`\g<0>`", text)


def forms(head: str, written: Iterable[SyntaxForm]) -> Iterator[str]:
    """Yield a table of syntax forms."""
    yield from table((head, "meaning"), ((f"`{form.written}`", form.meaning) for form in written))


def joints() -> Iterator[tuple[str, ...]]:
    """Yield each kind of joint: its motion, its coordinate, and its own properties."""
    has = {kind: allowed_properties(entity_type("joint", (), kind)) for kind in JOINTS}
    for kind, meaning in JOINTS.items():
        own = [name for name in has[kind] if not all(name in other for other in has.values())]
        counts = either([str(k) for k in has[kind]["low"].types]) if "low" in has[kind] else "—"
        yield f"`{kind}`", meaning, counts, ", ".join(f"`{name}`" for name in own) or "—"


def described(name: str, verb: Verb) -> Iterator[str]:
    """Yield a verb with a table of its arguments."""
    yield f"`{call(name, verb)}` {verb.meaning}.\n"
    slots = verb.arguments.items()
    yield from table(("argument", "values", "default", "meaning"), (row(n, slot) for n, slot in slots))


def call(name: str, verb: Verb) -> str:
    """Return the signature of a verb."""
    return f"{name}({', '.join(verb.arguments)}){' for TIME' if verb.lasts else ''}"


def arguments(verb: Verb) -> Iterator[str]:
    """Yield the arguments of a verb, one line each."""
    for name, slot in verb.arguments.items():
        _, takes, left_out, meaning = row(name, slot)
        values = f"{takes}; default {left_out}" if slot.default is not None else takes
        yield f"`{name}`: " + (takes if meaning == f"the {values}" else f"{meaning} ({values})")


def row(name: str, slot: PropertySpec, default: str = "") -> tuple[str, ...]:
    """Return a property or argument as a table row; `default` replaces the default that the slot states."""
    kinds = either([str(kind) for kind in slot.types])
    left_out = f"`{slot.default}`" if slot.default is not None else "—" if slot.optional else "required"
    meaning = re.sub(r"; default: [^.;]*", "", slot.meaning) if default else slot.meaning
    return f"`{name}`", kinds + bounds(slot), default or left_out, meaning


def bounds(slot: PropertySpec) -> str:
    """Return the limits of a slot's values, as text after its type."""
    if slot.among:
        return f", {either([f'`{word}`' for word in slot.among])}"
    if slot.least is not None and slot.most is not None:
        return f", {slot.least:g} to {slot.most:g}"
    limits = (("more than", slot.above), ("at least", slot.least), ("at most", slot.most))
    limits_text = "".join(f", {word} {bound:g}" for word, bound in limits if bound is not None)
    return f"{limits_text}, not 0" if slot.nonzero else limits_text


def article(noun: str) -> str:
    """Return the noun with its article."""
    return "an" if noun[0] in "aeio" else "a"


def table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> Iterator[str]:
    """A Markdown table and an empty line."""
    yield f"| {' | '.join(head)} |"
    yield f"|{'---|' * len(head)}"
    for cells in rows:
        yield f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |"
    yield ""


def main() -> None:
    """Write the pages, or exit with 1 if one is not current."""
    made = pages()
    if "--check" in sys.argv:
        sys.exit(any(not path.exists() or path.read_text(encoding="utf-8") != text for path, text in made.items()))
    FOLDER.mkdir(exist_ok=True)
    for path, text in made.items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
