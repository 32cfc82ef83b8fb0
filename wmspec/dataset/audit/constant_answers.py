"""Answers that are the same whatever is shown: the accuracy of the most frequent answer in each tier of difficulty.

A tier is a value of the stimulus difference. If it has one answer more often than others, "always yes" is right in it,
and the accuracy of the tier says nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from scipy import stats

from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.model import Finding

#: Tolerated accuracy above chance, and the probability of a false alarm in all tiers of a question.
SLACK, FALSE_ALARMS = 0.08, 0.01
#: The most tiers; a difference with more values is continuous.
MAX_TIERS = 12


def constant_answer_finding(unit: Unit) -> Finding | None:
    """Return whether one answer is right too often in a tier; None without tiers, or if options differ by question.

    A guesser may know which answers occur in a tier: of "left", "right" and "equal", two equal things have a tier of
    their own. So chance is that among the answers of the tier, and tiers with a single answer are left out.
    """
    cases = unit.per_instance
    offered = {tuple(sorted(case.row["option_name"] or ())) for case in cases}
    if unit.open or cases[0].has_picture_options or len(offered) != 1:
        return None
    tiers = {tier: answers for tier, answers in _tiers(cases).items() if len(set(answers)) > 1}
    if not 1 <= len(tiers) <= MAX_TIERS:
        return None
    worst, p = "", 1.0
    for tier, answers in tiers.items():
        answer, count = Counter(answers).most_common(1)[0]
        guess = 1 / len(set(answers))
        by_chance = min(1.0, stats.binomtest(count, len(answers), guess, "greater").pvalue / guess)
        if count / len(answers) > guess + SLACK and by_chance < p:
            right = f"always `{answer}` is right in {count:,} of {len(answers):,} questions of tier {tier}"
            worst, p = f"{right} (chance {guess:.0%}", by_chance
    if p * len(tiers) < FALSE_ALARMS:
        return Finding("constant answer", unit.name, "fails", f"{worst}, p = {p * len(tiers):.2g})")
    many = f"{len(tiers)} {'tier' if len(tiers) == 1 else 'tiers'}"
    return Finding("constant answer", unit.name, "holds", f"no answer is right too often in any of {many}")


def _tiers(cases: Sequence[Case]) -> dict[str, list[str]]:
    """Return the true answers of each tier, which is a value of the stimulus difference."""
    tiers: dict[str, list[str]] = {}
    for case in cases:
        if difference := case.row.get("difference"):
            name = f"{difference['name']} = {difference['value']:.4g} {difference['unit']}".strip()
            tiers.setdefault(name, []).append(case.row["option_name"][case.row["answer"]])
    return tiers


#: Share of questions with the actual answer above which, or of two options below one minus it, nothing is imagined.
MAX_SHARE = 0.9


def what_if_finding(unit: Unit) -> Finding | None:
    """Return the finding about what-ifs with words as answers; None for other questions."""
    cases = [case for case in unit.per_instance if case.row.get("actual_value") is not None and not case.open]
    if not cases:
        return None
    same = sum(case.row["answer_value"] == case.row["actual_value"] for case in cases) / len(cases)
    binary = all(case.count == 2 for case in cases)
    what = f"the answer is that of the episode as it is in {same:.0%} of {len(cases):,} what-if questions"
    if same > MAX_SHARE or (binary and same < 1 - MAX_SHARE):
        what += ", so they can be answered without imagining the change"
        return Finding("what-if", unit.name, "unclear", what)
    return Finding("what-if", unit.name, "holds", what)
