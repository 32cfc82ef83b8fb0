"""JSON form of checked tasks, and its schema.

Only this module imports pydantic, which takes as long to import as a spec to check.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import TypeAdapter, ValidationError

from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir.ir import TaskSpec


def to_json(spec: TaskSpec, indent: int | None = None) -> str:
    """Return a task as JSON, all numbers in SI units."""
    return _adapter().dump_json(spec, indent=indent).decode()


def from_json(text: str) -> TaskSpec:
    """Return the task of a JSON text. Raises WmsError with all validation errors.

    Validation is strict: no text for a number, no number for a truth value, no infinite numbers.
    """
    try:
        return _adapter().validate_json(text, strict=True)
    except ValidationError as error:
        wrong = (f"{'.'.join(map(str, e['loc'])) or 'the text'}: {e['msg']}" for e in error.errors())
        raise WmsError("this JSON is no checked task: " + "; ".join(wrong)) from None


def plain(spec: TaskSpec) -> dict[str, Any]:
    """Return a task as the plain values of its JSON."""
    document: dict[str, Any] = _adapter().dump_python(spec)
    return document


def schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of a task."""
    made = _adapter().json_schema(mode="serialization")
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **made}


@cache
def _adapter() -> TypeAdapter[TaskSpec]:
    return TypeAdapter(TaskSpec)
