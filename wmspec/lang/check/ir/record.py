"""A checked task as JSON and back, and the schema of that.

Nothing else needs pydantic, which takes as long to import as a spec to check.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import TypeAdapter, ValidationError

from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir.ir import TaskSpec


def to_json(spec: TaskSpec, indent: int | None = None) -> str:
    """A task as JSON, all numbers in SI units."""
    return _adapter().dump_json(spec, indent=indent).decode()


def from_json(text: str) -> TaskSpec:
    """The task of a JSON text. Raises WmsError with all that keeps it from being one.

    Nothing is taken for what it is not: no text for a number, no number for a truth value, and no number is infinite.
    """
    try:
        return _adapter().validate_json(text, strict=True)
    except ValidationError as error:
        wrong = (f"{'.'.join(map(str, e['loc'])) or 'the text'}: {e['msg']}" for e in error.errors())
        raise WmsError("this JSON is no checked task: " + "; ".join(wrong)) from None


def plain(spec: TaskSpec) -> dict[str, Any]:
    """A task as plain values, as they are in its JSON."""
    document: dict[str, Any] = _adapter().dump_python(spec)
    return document


def schema() -> dict[str, Any]:
    """The JSON schema (draft 2020-12) of a task."""
    made = _adapter().json_schema(mode="serialization")
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **made}


@cache
def _adapter() -> TypeAdapter[TaskSpec]:
    return TypeAdapter(TaskSpec)
