"""The IR: JSON and back without loss, by a published schema, and made in Python as well as from text."""

import json
import math
import pickle
from pathlib import Path
from typing import Any

import pydantic
import pytest
from click.testing import CliRunner
from hypothesis import given

from tests.examples import examples
from tests.language.specs import FEW, SPECS, random_spec, task_of
from wmspec.cli import main
from wmspec.core.diagnostics import Report, WmsError
from wmspec.core.places import Source
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.ir.record import from_json, plain, schema, to_json
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.parse.load import load_source

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.broad
@pytest.mark.parametrize("path", FEW, ids=lambda p: p.stem)
def test_shipped_specs_survive_json(path: Path) -> None:
    task = task_of(path)
    printed = CliRunner().invoke(main, ["compile", str(path), "--ir", "--task", task.name]).output
    assert from_json(printed) == task


@examples(5, 30)
@given(spec=random_spec())
def test_random_specs_survive_json(spec: TaskSpec) -> None:
    assert from_json(to_json(spec)) == spec


#: Older ones leave out what the classes say of themselves.
DESCRIBED = tuple(map(int, pydantic.VERSION.split(".")[:2])) >= (2, 13)


def undescribed(part: Any) -> Any:
    if isinstance(part, list):
        return [undescribed(each) for each in part]
    if isinstance(part, dict):
        return {k: undescribed(v) for k, v in part.items() if not (k == "description" and isinstance(v, str))}
    return part


def test_the_published_schema_is_current() -> None:
    """If it is not: `make generate`."""
    published = json.loads((DOCS / "schema.json").read_text())
    assert (published if DESCRIBED else undescribed(published)) == schema()
    assert json.loads(CliRunner().invoke(main, ["schema"]).output) == schema()


def test_every_part_of_the_schema_is_closed() -> None:
    parts = [schema(), *schema()["$defs"].values()]
    assert all(part["additionalProperties"] is False for part in parts if part.get("type") == "object")


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"format": 2}'])
def test_other_json_is_refused(text: str) -> None:
    with pytest.raises(WmsError, match="this JSON is no checked task"):
        from_json(text)


def test_a_task_of_the_future_is_refused() -> None:
    record = plain(task_of(SPECS[0])) | {"novelty": 1}
    with pytest.raises(WmsError, match=r"novelty: Unexpected keyword argument"):
        from_json(json.dumps(record))


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"repeat": "2"}, "repeat: Input should be a valid integer"),
        ({"repeat": True}, "repeat: Input should be a valid integer"),
        ({"title": 3}, "title: Input should be a valid string"),
        ({"tolerances": {"rest": "1"}}, "rest: Input should be a valid number"),
        ({"tolerances": {"rest": math.nan}}, "rest: Input should be a finite number"),
        ({"horizon": {"kind": "value", "value": math.inf}}, "value.float: Input should be a finite number"),
        ({"horizon": {"kind": "number", "value": 1.0}}, "horizon: .* 'number' found using 'kind' does not match"),
    ],
)
def test_ordinary_replies_are_not_misread(changed: dict[str, Any], said: str) -> None:
    record = plain(task_of(SPECS[0])) | changed
    with pytest.raises(WmsError, match=said):
        from_json(json.dumps(record))


def test_a_task_goes_to_another_process() -> None:
    made = task_of(SPECS[0])
    assert pickle.loads(pickle.dumps(made)) == made


@pytest.mark.broad
@pytest.mark.parametrize("path", FEW, ids=lambda p: f"{p.parent.stem}-{p.stem}")
def test_quantities_are_floats_and_lists_are_tuples(path: Path) -> None:
    """Nothing coerces what the checker makes: it must be what reading its JSON gives, to the type."""
    made = task_of(path)
    assert repr(made) == repr(from_json(to_json(made)))


@pytest.mark.parametrize("value", ["1e999", "1e300 * 1e300", "[1e999, 1]", "9e307 km"])
def test_no_number_is_infinite(value: str) -> None:
    text = f"use tabletop\ntask t : custom {{ let a = {value} observe front at [0 s] }}"
    report = Report()
    tasks = check_program(load_source(Source("test.wms", text), Path(), report), report)
    for task in tasks:
        assert from_json(to_json(task)) == task
    assert all(d.code == "WMS304" for d in report.diagnostics if d.severity == "error")
    assert math.isinf(float("1e999"))
