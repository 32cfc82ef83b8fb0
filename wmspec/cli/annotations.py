"""Diagnostics in the formats of code hosts: workflow commands of GitHub, code quality reports of GitLab.

Sources: "Workflow commands for GitHub Actions", GitHub Docs; "Code Quality report format", GitLab Docs.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from wmspec.cli.report_paths import relative_name
from wmspec.core.diagnostics import Diagnostic, place_record
from wmspec.core.disk_cache import digest
from wmspec.core.places import Place


def github(diagnostics: Iterable[Diagnostic]) -> str:
    """Return a workflow command a line, each an annotation of a file."""
    return "".join(f"{_command(d)}\n" for d in diagnostics)


def gitlab(diagnostics: Iterable[Diagnostic]) -> list[dict[str, Any]]:
    """Return a code quality report; it leaves out what has no place in a file."""
    issues: dict[str, dict[str, Any]] = {}
    for d in diagnostics:
        where = _where(d.place)
        if where:
            fingerprint = digest(f"{d.code}\0{where['file']}\0{where.get('line', 1)}\0{d.message}".encode())
            issues[fingerprint] = {
                "description": _text(d),
                "check_name": d.code,
                "fingerprint": fingerprint,
                "severity": "major" if d.severity == "error" else "minor",
                "location": {"path": where["file"], "lines": {"begin": where.get("line", 1)}},
            }
    return list(issues.values())


def _command(d: Diagnostic) -> str:
    where = _where(d.place)
    facts = {"title": f"wmspec {d.code}".strip(), **where}
    properties = ",".join(f"{name}={_escaped(str(value), properties=True)}" for name, value in facts.items())
    return f"::{d.severity} {properties}::{_escaped(_text(d))}"


def _text(d: Diagnostic) -> str:
    return d.message + (f" (help: {d.help})" if d.help else "")


def _where(place: Place | None) -> dict[str, Any]:
    """Return file, line and column of a place; empty if it is in no file."""
    where = place_record(place)
    if "file" not in where:
        return {}
    names = {"line": "line", "endLine": "endLine"}
    if where.get("endLine") in (None, where.get("line")):
        names |= {"column": "col", "endColumn": "endColumn"}
    return {"file": relative_name(where["file"]), **{short: where[n] for n, short in names.items() if n in where}}


def _escaped(text: str, *, properties: bool = False) -> str:
    escapes = [("%", "%25"), ("\r", "%0D"), ("\n", "%0A"), *([(":", "%3A"), (",", "%2C")] if properties else [])]
    for character, escape in escapes:
        text = text.replace(character, escape)
    return text
