"""The audit report as a self-contained page."""

from __future__ import annotations

from typing import Any

from wmspec.dataset.audit import balance, figures
from wmspec.dataset.audit.balance import MIN_STRENGTH, SIGNIFICANCE
from wmspec.dataset.audit.classify import FOLDS, FOREST_TREES
from wmspec.dataset.audit.duplicates import MIN_GROUPS
from wmspec.dataset.audit.model import Audit, Probe, Summary, Verdict
from wmspec.dataset.audit.power import FALSE_ALARMS, POWER
from wmspec.dataset.audit.probes import COMBINED_SLACK, MAX_MISSED_SHORTCUT, SLACK
from wmspec.dataset.audit.probes import verdict as probe_verdict
from wmspec.dataset.audit.stability import MIN_STABLE
from wmspec.dataset.build.webpage import webpage

#: Labels of verdicts.
WORDS: dict[Verdict, str] = {"fails": "fails", "unclear": "too few to tell", "reported": "reported", "holds": "holds"}
#: Labels of verdicts of a whole task.
OF_TASKS: dict[Verdict, str] = {"fails": "fail", "unclear": "unknown", "holds": "pass", "reported": ""}
#: Thresholds that the page explains.
_RULES = {
    "sure": SIGNIFICANCE,
    "strong": MIN_STRENGTH,
    "trees": FOREST_TREES,
    "folds": FOLDS,
    "slack": SLACK,
    "combined": COMBINED_SLACK,
    "alarms": FALSE_ALARMS,
    "room": MAX_MISSED_SHORTCUT,
    "power": POWER,
    "least_groups": MIN_GROUPS,
    "guessing": balance.MAX_MISSED_GAIN,
    "least_stable": MIN_STABLE,
}


def page(audit: Audit) -> str:
    """Return the page: HTML with style and figures inside; deterministic."""
    tasks = dict.fromkeys([c.task for c in audit.counts] + [t.task for t in audit.tests])
    return webpage(
        "wmspec.dataset.audit",
        audit=audit,
        verdict=verdict(audit),
        overview=overview(audit),
        tasks=[_task(audit, task) for task in tasks if any(t.task == task for t in audit.tests)],
        figures=figures,
        verdict_of=probe_verdict,
        words=WORDS,
        kinds={word: verdict for verdict, word in OF_TASKS.items()},
        rules=_RULES,
    )


def _task(audit: Audit, task: str) -> dict[str, Any]:
    """Return the results of a task; `best` is the best probe of each family."""
    best: dict[tuple[str, bool], Probe] = {}
    probes = [p for p in audit.probes if p.task == task]
    for probe in sorted(probes, key=lambda p: p.chance - p.accuracy):
        best.setdefault((probe.family, probe.judged), probe)
    return {
        "name": task,
        "probes": probes,
        "best": list(best.values()),
        "tests": [t for t in audit.tests if t.task == task],
        "likeness": [like for like in audit.likeness if like.task == task],
        "spreads": [s for s in audit.spreads if s.task == task],
    }


def verdict(audit: Audit) -> str:
    """Return the outcome in a sentence."""
    number = {v: sum(s.verdict == v for s in audit.summaries) for v in ("holds", "unclear", "fails")}
    wording = {"holds": "pass", "unclear": "are inconclusive", "fails": "fail"}
    many = len(audit.summaries)
    tasks = ", ".join(f"{number[v]:,} {wording[v]}" for v in number if number[v])
    whole = "" if audit.passed or number["fails"] else "; files of the dataset are gone"
    return f"Of {many:,} {'task' if many == 1 else 'tasks'}, {tasks}{whole}."


def overview(audit: Audit) -> list[list[str]]:
    """Return the summary table: a header, and a row for each task, failing ones first."""
    order = ("fails", "unclear", "holds")
    head = ["task", "verdict", "why", "questions", "groups", "best probe", "above chance", "found from", "stable"]
    return [head, *map(_line, sorted(audit.summaries, key=lambda s: (order.index(s.verdict), s.task)))]


def _line(of: Summary) -> list[str]:
    points = [f"{100 * of.above:+.0f}" if of.above is not None else "", ""]
    if of.least is not None:
        points[1] = f"{100 * of.least:.0f}" if of.least < 1 else "none"
    stable = "" if of.stable is None else f"{of.stable:.1%}"
    words = [of.task, OF_TASKS[of.verdict], ", ".join(of.why), f"{of.questions:,}", f"{of.groups:,}", of.best]
    return [*words, *points, stable]
