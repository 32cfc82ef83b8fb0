"""What a factor is about: declared with `about`, or derived from what it changes."""

from pathlib import Path

import pytest

from tests.language.specs import task_from
from wmspec.compile.design.dimension import dimension
from wmspec.core.diagnostics import SpecError, WmsError
from wmspec.core.places import Source
from wmspec.editor.complete import complete
from wmspec.editor.document import Document
from wmspec.editor.hover import hover
from wmspec.lang.check.statements.builder import factor
from wmspec.lang.check.tables.vocabulary import DIMENSION_ALIASES, FACTOR_DIMENSIONS
from wmspec.lang.parse.format import format_spec

SPEC = """use tabletop
task t : custom {{
  factor f in {}
  nuisance n in 1 .. 2
  let colors = [red, green, blue]
  let big    = f
  object a {{ shape: cube  size: 6 cm  on: table {} }}
  observe front at [0 s]
}}
"""


def about(domain: str, properties: str = "") -> str:
    spec = task_from(SPEC.format(domain, properties))
    return dimension(spec, spec.factor("f"))


@pytest.mark.parametrize("name", FACTOR_DIMENSIONS)
def test_a_declared_dimension_is_the_one_of_the_factor(name: str) -> None:
    """For any factor, also in Python."""
    assert about(f"[1, 2] about {name}", "color: pick(colors, f)") == name
    assert factor("f", [1, 2], about=name).about == name


@pytest.mark.parametrize(
    ("domain", "properties", "name"),
    [
        ("[red, blue]", "", "color"),
        ("[cube, sphere]", "", "shape"),
        ("[wood, metal]", "", "material"),
        ("[0, 1]", "color: pick(colors, f)", "color"),
        ("[0, 1]", "color: pick(colors, big)", "color"),
        ("[1, 2] cm", "at (f, 0)", "position"),
        ("[10, 20] deg", "yaw: big", "position"),
        ("[1, 2] kg", "mass: f", "other"),
        ("[0, 1]", "color: pick(colors, f)  mass: (f + 1) * 1 kg", "other"),
        ("[1, 2]", "", "other"),
    ],
)
def test_a_dimension_follows_from_what_a_factor_changes(domain: str, properties: str, name: str) -> None:
    assert about(domain, properties) == name


def test_factor_of_size_and_place_is_about_size() -> None:
    spec = task_from(SPEC.format("[6, 8] cm", "at (big, 0)").replace("size: 6 cm", "size: f"))
    assert dimension(spec, spec.factor("f")) == "size"


@pytest.mark.parametrize(
    ("written", "intended"), [*DIMENSION_ALIASES.items(), ("colr", "color"), ("postion", "position")]
)
def test_an_unknown_dimension_is_an_error_with_a_remedy(written: str, intended: str) -> None:
    with pytest.raises(SpecError) as raised:
        about(f"[1, 2] about {written}")
    (found,) = raised.value.diagnostics
    assert found.code == "WMS201"
    assert f"`{written}`" in found.message
    assert intended in found.help


def test_an_unknown_dimension_in_python_is_an_error() -> None:
    with pytest.raises(WmsError, match="did you mean `color`"):
        factor("f", [1, 2], about="colr")


def test_about_is_no_reserved_word_and_no_unit() -> None:
    spec = task_from(SPEC.format("[1, 2] about color\n factor about in 0 .. 3 by 1 about size", ""))
    assert [(f.name, f.about) for f in spec.factors] == [("f", "color"), ("about", "size"), ("n", "")]


def test_a_dimension_refers_to_no_declaration() -> None:
    """A factor, a `let` or an object may be named as a dimension is."""
    spec = task_from(SPEC.format("[red, blue] about color\n  factor color in [1, 2] about color", ""))
    assert [f.about for f in spec.factors] == ["color", "color", ""]


def test_dimensions_are_aligned() -> None:
    text = "factor a in [1, 2] about color\nfactor bcd in 0 .. 5 by 1 about size  # how large\nfactor e in [1]\n"
    assert format_spec(Source("t", text)) == (
        "factor a   in [1, 2]      about color\nfactor bcd in 0 .. 5 by 1 about size  # how large\nfactor e   in [1]\n"
    )


def test_the_editor_offers_and_explains_dimensions() -> None:
    text = SPEC.format("[1, 2] about color", "")
    document = Document(Path("t.wms"), text)
    place = text.index("color")
    found = hover(document, place + 1)
    assert found is not None
    assert FACTOR_DIMENSIONS["color"] in found.markdown
    offered = {offer.word for offer in complete(document, place).offers}
    assert offered == FACTOR_DIMENSIONS.keys()
