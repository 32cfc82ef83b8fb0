"""Diagnostics as SARIF 2.1.0 (OASIS standard, 27 March 2020), for code hosts and editors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any
from urllib.parse import quote

from wmspec import __version__
from wmspec.cli.report_paths import file_of, source_root
from wmspec.core.diagnostics import Diagnostic, place_record
from wmspec.core.places import Place
from wmspec.lang.parse.codes import CODES

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"


#: The base of relative URIs: the root of the repository.
_BASE = "SRCROOT"


def sarif(diagnostics: Iterable[Diagnostic], rules: Mapping[str, str] = CODES) -> dict[str, Any]:
    """Return a SARIF log with one run. `rules` are the meanings of all codes, those of the language by default."""
    described: list[dict[str, Any]] = []
    for code, meaning in rules.items():
        help = {"help": {"text": f"wmspec explain {code}"}} if code in CODES else {}
        described.append({"id": code, "shortDescription": {"text": meaning}, **help})
    driver = {"name": "wmspec", "semanticVersion": __version__, "rules": described}
    run = {
        "tool": {"driver": driver},
        "originalUriBaseIds": {_BASE: {"uri": f"{source_root().as_uri()}/"}},
        "columnKind": "unicodeCodePoints",
        "results": [_result(diagnostic, list(rules)) for diagnostic in diagnostics],
    }
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


def _result(diagnostic: Diagnostic, rules: list[str]) -> dict[str, Any]:
    help = f" (help: {diagnostic.help})" if diagnostic.help else ""
    result: dict[str, Any] = {
        "ruleId": diagnostic.code,
        "ruleIndex": rules.index(diagnostic.code),
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
    where = place_record(place)
    if "prim" in where:
        return {"logicalLocations": [{"fullyQualifiedName": where["prim"]}]}
    names = {"line": "startLine", "column": "startColumn", "endLine": "endLine", "endColumn": "endColumn"}
    region = {name: where[key] for key, name in names.items() if key in where}
    physical = {"artifactLocation": _artifact(where["file"])}
    return {"physicalLocation": physical | ({"region": region} if region else {})}


def _artifact(name: str) -> dict[str, str]:
    """Return the URI of a file: relative to the root of the repository, or absolute if it is elsewhere."""
    path = file_of(name)
    root = source_root()
    if path is None:
        return {"uri": quote(name)}
    if path.is_relative_to(root):
        return {"uri": quote(path.relative_to(root).as_posix()), "uriBaseId": _BASE}
    return {"uri": path.as_uri()}
