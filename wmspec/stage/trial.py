"""Trying a spec out: the scenes of a sample of instances and counterfactuals are built, nothing is executed."""

from __future__ import annotations

import re

from wmspec.check.ir import TaskSpec
from wmspec.design.design import Design
from wmspec.errors import WmsError
from wmspec.parse.diagnostics import Report
from wmspec.parse.load import located, read_source
from wmspec.parse.source import Source, Span
from wmspec.stage.episode import document

#: How many instances are tried, and how many of them with every counterfactual.
TRIED, TRIED_CHANGED = 24, 8


def trial(spec: TaskSpec, report: Report) -> int:
    """Report what goes wrong with the values of a spec; returns the number of its instances (0 if there are none)."""
    try:
        design = Design(spec)
    except WmsError as error:
        _report(str(error), "WMS402" if "no combination" in str(error) else "WMS404", report)
        return 0
    try:
        for tried, index in enumerate(design.sample(TRIED)):
            truth = document(spec, design[index])
            for question in spec.questions:
                for change in question.counterfactuals if tried < TRIED_CHANGED else ():
                    if not truth.differing(document(spec, design[index], change)):
                        raise WmsError(f"{change.place}: `{change.name}` changes nothing in instance {index}")
    except WmsError as error:
        _report(str(error), "WMS503" if "changes nothing" in str(error) else "WMS304", report)
    return len(design)


def _report(message: str, code: str, report: Report) -> None:
    """Point at the place that a message begins with."""
    match = re.search(r"([^\s:;][^:;]*):(\d+):(\d+): ", message)
    if match is None:
        span = Span(Source("<spec>", " "), 0, 0)
        report.add(code, message, span)
        return
    source = read_source(located(match[1]))
    lines = source.text.split("\n")
    start = sum(len(line) + 1 for line in lines[: int(match[2]) - 1]) + int(match[3]) - 1
    word = re.match(r"[^\n]*", source.text[start:])
    end = start + len((word[0] if word else "").rstrip())
    report.add(code, message[: match.start()] + message[match.end() :], Span(source, start, end))
