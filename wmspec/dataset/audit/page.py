"""The report of an audit as one page that opens anywhere."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files

from wmspec.dataset.audit import balance, figures
from wmspec.dataset.audit.balance import STRONG, SURE
from wmspec.dataset.audit.classify import FOLDS, TREES
from wmspec.dataset.audit.groups import LEAST_GROUPS
from wmspec.dataset.audit.model import Audit, Finding, Likeness, Probe, Summary, Test, Verdict
from wmspec.dataset.audit.power import ALARMS, POWER
from wmspec.dataset.audit.probes import ROOM, SLACK
from wmspec.dataset.audit.probes import verdict as probe_verdict
from wmspec.dataset.audit.stability import LEAST_STABLE

#: What verdicts are called.
WORDS: dict[Verdict, str] = {"fails": "fails", "unclear": "too few to tell", "told": "to judge", "holds": "holds"}
#: What they are called of a task as a whole.
OF_TASKS: dict[Verdict, str] = {"fails": "fail", "unclear": "unknown", "holds": "pass", "told": ""}


def page(audit: Audit) -> str:
    """The page: HTML with its style and figures inside, the same for the same findings."""
    style = (files("wmspec.dataset.audit") / "page.css").read_text(encoding="utf-8")
    tasks = list(dict.fromkeys([c.task for c in audit.counts] + [t.task for t in audit.tests]))
    body = [_head(audit), _tasks(audit), _findings(audit.findings), _counts(audit)]
    body += [*(_task(audit, task) for task in tasks), _rules()]
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Audit of {escape(audit.dataset)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
        f"<main>\n{chr(10).join(filter(None, body))}\n</main>\n</body>\n</html>\n"
    )


def verdict(audit: Audit) -> str:
    """The outcome in a sentence."""
    number = {v: sum(s.verdict == v for s in audit.summaries) for v in ("holds", "unclear", "fails")}
    wording = {"holds": "pass", "unclear": "cannot be told", "fails": "fail"}
    many = len(audit.summaries)
    tasks = ", ".join(f"{number[v]:,} {wording[v]}" for v in number if number[v])
    whole = "" if audit.passed or number["fails"] else "; files of the dataset are gone"
    return f"Of {many:,} {'task' if many == 1 else 'tasks'}, {tasks}{whole}."


def overview(audit: Audit) -> list[list[str]]:
    """The first page as cells: a head, and a line for each task, the failing ones first."""
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


def _head(audit: Audit) -> str:
    about = audit.about
    versions = ", ".join(f"{name} {number}" for name, number in (about.get("versions") or {}).items())
    summary = f"{about['rows']:,} questions in {', '.join(about['engines'])}, seed {about['seed']} ({versions})"
    seen = f"The pictures of at most {about['pictures of at most']:,} instances of each task were looked at."
    kind = "holds" if audit.passed else "fails"
    return (
        f"<h1>Audit of {escape(audit.dataset)}</h1>\n"
        f'<p class="about">{escape(summary)}. {seen}</p>\n<p class="verdict {kind}">{verdict(audit)}</p>'
    )


def _tasks(audit: Audit) -> str:
    """The first page: every task in a line."""
    head, *lines = overview(audit)
    kinds = {OF_TASKS[verdict]: verdict for verdict in OF_TASKS}
    numbers = ["questions", "groups", "above chance", "found from", "stable"]
    rows = [
        "".join(
            f'<td class="number">{escape(cell)}</td>'
            if name in numbers
            else f'<td class="mark {kinds[cell]}">{escape(cell)}</td>'
            if name == "verdict"
            else f"<td>{escape(cell)}</td>"
            for name, cell in zip(head, line, strict=True)
        )
        for line in lines
    ]
    meaning = (
        "Groups are the independent control groups that the questions come from. The best probe is the judged one that "
        "is furthest above chance, in points of accuracy; each of them would have found a shortcut of so many points."
    )
    return f'<h2>Tasks</h2>\n{_table(head, rows, numbers)}\n<p class="note">{meaning}</p>'


# ---------------------------------------------------------------- findings


def _findings(findings: Sequence[Finding]) -> str:
    loud = [f for f in findings if f.verdict in ("fails", "unclear")]
    quiet = [f for f in findings if f not in loud]
    shown = _finding_table(loud) if loud else ""
    return (
        f"<h2>Findings</h2>\n{shown}\n<details><summary>{len(quiet):,} more</summary>{_finding_table(quiet)}</details>"
    )


def _finding_table(findings: Iterable[Finding]) -> str:
    rows = [
        f'<td class="mark {f.verdict}">{WORDS[f.verdict]}</td><td>{escape(f.check)}</td>'
        f"<td>{escape(f.task)}</td><td>{escape(f.what)}</td>"
        for f in findings
    ]
    return _table(["", "check", "task", "what was seen"], rows)


def _table(head: Sequence[str], rows: Iterable[str], numbers: Sequence[str] = ()) -> str:
    kind = {name: ' class="number"' if name in numbers else "" for name in head}
    top = "".join(f"<th{kind[name]}>{escape(name)}</th>" for name in head)
    body = "\n".join(f"<tr>{row}</tr>" for row in rows)
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead>\n<tbody>{body}</tbody></table></div>'


def _counts(audit: Audit) -> str:
    rows = [
        f"<td>{escape(c.task)}</td><td>{escape(c.dimension)}</td>"
        + "".join(_number(f"{n:,}") for n in (c.instances, c.asked, c.kept, c.asked - c.kept))
        for c in audit.counts
    ]
    numbers = ["instances", "asked", "kept", "rejected"]
    table = _table(["task", "dimension", *numbers], rows, numbers)
    return f"<h2>Counts</h2>\n{table}\n{figures.rejected(audit.counts) if audit.counts else ''}"


def _number(number: str) -> str:
    return f'<td class="number">{number}</td>'


# ---------------------------------------------------------------- a task


def _task(audit: Audit, task: str) -> str:
    probes = [p for p in audit.probes if p.task == task]
    tests = [t for t in audit.tests if t.task == task]
    if not tests:
        return ""
    parts = [f"<h2>{escape(task)}</h2>", "<h3>Shortcuts</h3>"]
    parts += _probes(probes)
    parts += [f"<h3>Each {t.first}</h3>{figures.shares(t)}" for t in tests if not t.second]
    parts.append(f"<h3>What goes with what</h3>{_tests([t for t in tests if t.second])}")
    parts += [_likeness(like) for like in audit.likeness if like.task == task]
    spreads = [figures.spread(s) for s in audit.spreads if s.task == task]
    return "\n".join([*parts, *(["<h3>Stimulus difference</h3>", *spreads] if spreads else [])])


def _probes(probes: Sequence[Probe]) -> list[str]:
    """The best probe of each family in a figure, and all of them in a table."""
    if not probes:
        return ['<p class="note">Too few questions to look for any.</p>']
    best: dict[tuple[str, bool], Probe] = {}
    for probe in sorted(probes, key=lambda p: p.chance - p.accuracy):
        best.setdefault((probe.family, probe.judged), probe)
    rows = [
        f'<td class="mark {verdict}">{WORDS[verdict]}</td><td>{escape(p.sees)}</td>'
        + "".join(map(_number, (f"{p.accuracy:.0%}", f"{p.chance:.0%}", f"{p.low:.0%} to {p.high:.0%}")))
        + _number((f"{100 * p.least:.0f} points" if p.least < 1 else "none") if p.judged else "not judged")
        for p, verdict in ((p, probe_verdict(p)) for p in probes)
    ]
    numbers = ["accuracy", "chance", "interval", "found from"]
    table = _table(["", "sees", *numbers], rows, numbers)
    return [figures.probes(list(best.values())), f"<details><summary>{len(probes):,} probes</summary>{table}</details>"]


def _tests(tests: Sequence[Test]) -> str:
    rows = [
        f"<td>{escape(t.first)}</td><td>{escape(t.second)}</td><td>{_contingency(t)}</td><td>{escape(t.method)}</td>"
        + "".join(_number(f"{n:.2g}") for n in (t.strength, t.p))
        + (_number(f"{t.corrected:.2g}") if t.judged else _number("not judged"))
        for t in tests
    ]
    numbers = ["strength", "p", "corrected"]
    return _table(["", "", "counts", "test", *numbers], rows, numbers)


def _contingency(test: Test) -> str:
    rows = [
        f"<td>{escape(name)}</td>" + "".join(_number(f"{n:,}") for n in counts)
        for name, counts in zip(test.rows, test.counts, strict=True)
    ]
    table = _table(["", *test.columns], rows, test.columns)
    return f"<details><summary>{len(test.rows)} × {len(test.columns)}</summary>{table}</details>"


def _likeness(like: Likeness) -> str:
    pairs = "".join(f"<li>{escape(name)}: {gap:.2%}</li>" for name, gap in like.pairs.items())
    least, _, middle, _, most = like.quantiles
    return (
        f"<h3>Likeness of options</h3><p>The two closest options differ in {middle:.2%} of the picture (median; "
        f"{least:.2%} to {most:.2%}). Closest: {escape(like.closest)}. Medians by pair:</p><ul>{pairs}</ul>"
    )


def _rules() -> str:
    return (
        "<h2>Rules</h2>\n"
        "<p>A dependence fails if, after Holm's correction for all of its task that are judged, its probability is "
        f"below {SURE:g} and its strength (Cramér's V, Cohen's w) at least {STRONG:g}. The answer may hang on factors; "
        "that is told, not judged.</p>\n"
        f"<p>A probe is a lasso on words or options, or a forest of {TREES} trees on pictures and what is "
        f"in them, fitted to {FOLDS - 1} of {FOLDS} parts of the control groups and judged on the other. It fails if "
        f"its accuracy is more than {SLACK:.0%} above chance and that is no luck: by luck any of a task's probes gets "
        f"so far in {ALARMS:.0%} of sound datasets. It is unknown if it might have overlooked a shortcut of more than "
        f"{ROOM:.0%} above chance: shortcuts of known sizes are planted, and it has to find {POWER:.0%} of them. "
        "Probes that see fewer moments than it takes to see the answer are judged; the others are told.</p>\n"
        f"<p>Fewer than {LEAST_GROUPS} control groups are too few to speak of more than these. A test of balance is "
        f"unknown if it might have overlooked what makes guessing {balance.ROOM:.0%} better. Answers are unstable if "
        f"surely fewer than {LEAST_STABLE:.0%} hold in all engines and after a nudge.</p>"
    )
