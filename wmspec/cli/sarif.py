"""Diagnostics as SARIF 2.1.0 (OASIS standard, 27 March 2020), for code hosts and editors."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any
from urllib.parse import quote

from wmspec import __version__
from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import FilePlace, Location, Place, PrimPlace, Span
from wmspec.lang.parse.codes import CODES

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"


def sarif(diagnostics: Iterable[Diagnostic]) -> dict[str, Any]:
    """Return a SARIF log with one run; its rules are all codes of the language."""
    rules = [
        {"id": code, "shortDescription": {"text": meaning}, "help": {"text": f"wmspec explain {code}"}}
        for code, meaning in CODES.items()
    ]
    driver = {"name": "wmspec", "semanticVersion": __version__, "rules": rules}
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [_result(diagnostic) for diagnostic in diagnostics],
    }
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


def _result(diagnostic: Diagnostic) -> dict[str, Any]:
    help = f" (help: {diagnostic.help})" if diagnostic.help else ""
    result: dict[str, Any] = {
        "ruleId": diagnostic.code,
        "ruleIndex": list(CODES).index(diagnostic.code),
        "level": diagnostic.severity,
        "message": {"text": diagnostic.message + help},
    }
    if diagnostic.place:
        result["locations"] = [_location(diagnostic.place)]
    if diagnostic.notes:
        result["relatedLocations"] = [
            {"id": i, "message": {"text": note.message}, **_location(note.place)}
            for i, note in enumerate(diagnostic.notes)
        ]
    return result


def _location(place: Place) -> dict[str, Any]:
    match place:
        case Span():
            line, column = place.source.position(place.end)
            region = {"startLine": place.line, "startColumn": place.column, "endLine": line, "endColumn": column}
            return _physical(place.source.name, region)
        case Location():
            return _physical(place.file, {"startLine": place.line, "startColumn": place.column})
        case FilePlace():
            return _physical(place.path, {"startLine": place.line} if place.line else {})
        case PrimPlace():
            return {"logicalLocations": [{"fullyQualifiedName": place.path}]}


def _physical(name: str, region: dict[str, int]) -> dict[str, Any]:
    where = {"artifactLocation": {"uri": _uri(name)}}
    return {"physicalLocation": where | ({"region": region} if region else {})}


def _uri(name: str) -> str:
    """Return a path as a URI: relative to the working folder, or with a scheme."""
    path = Path(name)
    return path.as_uri() if path.is_absolute() else quote(path.as_posix())
