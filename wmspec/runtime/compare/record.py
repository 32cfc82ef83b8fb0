"""Machine-readable crosschecks: JSON, and JUnit XML for continuous integration. Neither contains a time of day."""

from __future__ import annotations

import re
from collections.abc import Sequence, Set
from dataclasses import asdict
from typing import Any
from xml.etree import ElementTree as ET

from wmspec import __version__
from wmspec.runtime.compare.disagreement import complaints
from wmspec.runtime.compare.model import CheckResult
from wmspec.runtime.compare.summary import lines, suspects, unreliable_answers
from wmspec.runtime.compare.sweep import SweepConfig, pairs
from wmspec.runtime.compare.verbalize import failure, parting
from wmspec.runtime.engines.registry import engine_version

#: Version of the JSON layout.
FORMAT = 1


def record(
    job: SweepConfig, checked: Sequence[CheckResult], strict: bool, failed: Set[tuple[str, int]]
) -> dict[str, Any]:
    """Return the crosscheck as JSON values, in SI units. `failed` are the tasks and indices that count as failures."""
    return {
        "format": FORMAT,
        "wmspec": __version__,
        "engines": {name: engine_version(name) for name in job.engines},
        "seed": job.seed,
        "strict": strict,
        "tolerances": {task: asdict(limits) for task, limits in job.tolerances},
        "passes": not failed,
        "summary": [asdict(line) for line in lines(checked, pairs(job.engines))],
        "suspects": [asdict(s) for s in suspects(checked)],
        "doubtful": [asdict(d) for d in unreliable_answers(checked)],
        "instances": [_instance(c, strict, (c.task, c.index) in failed) for c in checked],
    }


def _instance(checked: CheckResult, strict: bool, failed: bool) -> dict[str, Any]:
    comparisons = [asdict(c) | {"within": c.within} for c in checked.comparisons]
    verdicts = [asdict(v) | {"asked": v.is_accepted} for v in checked.verdicts]
    return {
        **asdict(checked),
        "passes": checked.passes(strict),
        "known": not failed and not checked.passes(strict),
        "complaints": complaints(checked, strict),
        "comparisons": comparisons,
        "verdicts": verdicts,
    }


def junit(job: SweepConfig, checked: Sequence[CheckResult], strict: bool, failed: Set[tuple[str, int]]) -> str:
    """Return JUnit XML: a suite per task, a case per instance; passing deviations are in its output.

    Instances that do not pass and are not in `failed` are known; they are skipped.
    """
    root = ET.Element("testsuites", name="wmspec crosscheck")
    for task in dict.fromkeys(c.task for c in checked):
        cases = [c for c in checked if c.task == task]
        wrong = [c for c in cases if (c.task, c.index) in failed]
        errors, known = sum(bool(c.failures) for c in wrong), sum(not c.passes(strict) for c in cases) - len(wrong)
        counts = {"tests": len(cases), "failures": len(wrong) - errors, "errors": errors, "skipped": known}
        suite = ET.SubElement(root, "testsuite", name=task)
        suite.attrib.update((k, str(v)) for k, v in counts.items())
        properties = ET.SubElement(suite, "properties")
        for name in job.engines:
            ET.SubElement(properties, "property", name=name, value=engine_version(name))
        for case in cases:
            _case(suite, case, job, strict, known=(case.task, case.index) not in failed)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _case(suite: ET.Element, checked: CheckResult, job: SweepConfig, strict: bool, known: bool) -> None:
    name = f"{checked.task}[{checked.index}]"
    case = ET.SubElement(suite, "testcase", classname=f"crosscheck.{checked.task}", name=name)
    reasons = complaints(checked, strict)
    if reasons and known:
        ET.SubElement(case, "skipped", message=_clean(f"known: {reasons[0]}"))
    elif checked.failures:
        error = ET.SubElement(case, "error", type="failure", message=_clean(failure(checked.failures[0])))
        error.text = _clean("\n".join(reasons))
    elif reasons:
        kind = "answers" if checked.disputed else "trajectories"
        element = ET.SubElement(case, "failure", type=kind, message=_clean(reasons[0]))
        element.text = _clean("\n".join(reasons))
    out = [f"{k} = {v}" for k, v in checked.factors.items()]
    out += [f"wmspec crosscheck: seed {job.seed}, instance {checked.index}", *map(parting, checked.parted)]
    ET.SubElement(case, "system-out").text = _clean("\n".join(out))


def _clean(text: str) -> str:
    """Return the text without characters that XML 1.0 excludes."""
    return re.sub(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "?", text)
