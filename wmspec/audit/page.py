"""The report of an audit as one page that opens anywhere."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files

from wmspec.audit import figures
from wmspec.audit.balance import STRONG, SURE
from wmspec.audit.model import Audit, Finding, Likeness, Test, Verdict
from wmspec.audit.probes import CONFIDENCE, ROOM, SLACK

#: What verdicts are called.
WORDS: dict[Verdict, str] = {"fails": "fails", "unclear": "too few to tell", "told": "to judge", "holds": "holds"}


def page(audit: Audit) -> str:
    """The page: HTML with its style and figures inside, the same for the same findings."""
    style = (files("wmspec.audit") / "page.css").read_text(encoding="utf-8")
    tasks = list(dict.fromkeys([c.task for c in audit.counts] + [t.task for t in audit.tests]))
    body = [_head(audit), _findings(audit.findings), _counts(audit), *(_task(audit, task) for task in tasks), _rules()]
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Audit of {escape(audit.dataset)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
        f"<main>\n{chr(10).join(filter(None, body))}\n</main>\n</body>\n</html>\n"
    )


def verdict(audit: Audit) -> str:
    """The outcome in a sentence."""
    count = {v: sum(f.verdict == v for f in audit.findings) for v in WORDS}
    if count["fails"]:
        return f"{count['fails']:,} of {len(audit.findings):,} checks fail."
    unclear = f"; for {count['unclear']:,} there are too few questions to tell" if count["unclear"] else ""
    return f"Nothing fails in {len(audit.findings):,} checks{unclear}."


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
    parts.append(figures.probes(probes, SLACK) if probes else '<p class="note">Too few questions to look for any.</p>')
    parts += [f"<h3>Each {t.first}</h3>{figures.shares(t)}" for t in tests if not t.second]
    parts.append(f"<h3>What goes with what</h3>{_tests([t for t in tests if t.second])}")
    parts += [_likeness(like) for like in audit.likeness if like.task == task]
    spreads = [figures.spread(s) for s in audit.spreads if s.task == task]
    return "\n".join([*parts, *(["<h3>Stimulus difference</h3>", *spreads] if spreads else [])])


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
        "<p>A dependence fails if, after Holm's correction for all that are judged here, its probability is below "
        f"{SURE:g} and its strength (Cramér's V, Cohen's w) at least {STRONG:g}. The answer may hang on factors; that "
        "is told, not judged.</p>\n"
        "<p>A probe is a ridge regression, fitted to four fifths of the control groups and judged on the others. Its "
        f"intervals are exact (Clopper and Pearson), all judged ones together at {CONFIDENCE:.0%}. It fails if all of "
        f"its interval is more than {SLACK:.0%} above chance; if the interval reaches more than {ROOM:.0%} above "
        "chance, there are too few questions to tell. Probes that see none of the pictures shown are judged; those "
        "that see one are judged only if the question shows several moments, because a still question is meant to be "
        "answered from a picture.</p>"
    )
