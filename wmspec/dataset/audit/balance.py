"""Balance: tests that answers, positions of the true option and nuisances are independent.

Answers are expected to depend on factors; this is reported but never fails the audit.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit.cases import Case, Unit, task_of
from wmspec.dataset.audit.model import Finding, Test, Verdict
from wmspec.dataset.audit.statistics import Table, contingency_table, dependence, detectable, goodness_of_fit, holm

#: Numbers with more distinct values are binned into quarters, or into halves if a quarter would have fewer cases.
MAX_VALUES, MIN_CASES = 8, 20
#: A dependence fails below this corrected p-value and above this strength (Cramér's V).
SIGNIFICANCE, MIN_STRENGTH = 0.01, 0.1
#: A test is inconclusive if it could miss a dependence that raises guessing by more than this.
MAX_MISSED_GAIN = 0.35

PLACE, ANSWER = "place of the truth", "answer"


def tests(unit: Unit) -> list[Test]:
    """Return all tests of a unit's questions, with one row for each instance."""
    first = unit.per_instance[0]
    factors, nuisances = first.varied("factor"), first.varied("nuisance")
    made = []
    if not first.has_picture_options:
        made += [_test(unit, ANSWER, n, True) for n in nuisances]
        made += [_test(unit, ANSWER, f, False) for f in factors]
    if not first.open:
        made += [_uniform(unit, PLACE), *(_test(unit, PLACE, n, True) for n in (*factors, *nuisances))]
    if not first.open and not first.has_picture_options:
        made += [_uniform(unit, ANSWER), _test(unit, PLACE, ANSWER, True)]
    return made


def corrected_tests(tested: Sequence[Test]) -> list[Test]:
    """Return the tests with corrected p-values and the weakest detectable dependence.

    In a task, tests of answers form one family and tests of positions another, each with half of the false alarms.
    Otherwise the many tests of positions would take power from the few of answers, which have one case in each group.
    Tests of metadata are a third family, with as many false alarms as both.
    """
    families: dict[tuple[str, ...], list[int]] = {}
    for i, test in enumerate(tested):
        if test.judged:
            family = test.first if test.check == "balance" else test.check
            families.setdefault((task_of(test.task), family), []).append(i)
    made = [
        test
        if test.judged
        else replace(test, corrected=test.p, least=detectable(test.counts, SIGNIFICANCE, test.effect))
        for test in tested
    ]
    for (_, family), those in families.items():
        shares = 2 if family in (PLACE, ANSWER) else 1
        level = SIGNIFICANCE / shares / len(those)
        for i, p in zip(those, holm([tested[i].p for i in those]), strict=True):
            least = detectable(tested[i].counts, level, tested[i].effect)
            made[i] = replace(tested[i], corrected=min(1.0, shares * p), least=least)
    return made


def guessing_gain(test: Test) -> float:
    """Return the gain over guessing (0 to 1) from the weakest detectable dependence.

    The dependence is assumed to determine the answer of as many cases as its strength permits, and to say nothing about
    the others.
    """
    rows, columns = sum(map(any, test.counts)), sum(map(any, zip(*test.counts, strict=True)))
    if not test.second:  # one value is more frequent, the others less
        return min(1.0, test.least * sqrt(max(0, columns - 1)) / max(1, columns))
    return test.least * (min(rows, columns) - 1) / rows


def judge(test: Test) -> Finding:
    """Return the finding of a test."""
    count = sum(map(sum, test.counts))
    what = f"{test.first} and {test.second} are independent" if test.second else f"the {test.first} is uniform"
    wrong = f"{test.first} depends on {test.second}" if test.second else f"the {test.first} is not uniform"
    how = f"({test.method}, p = {test.corrected:.2g}, strength {test.strength:.2f}, {count:,} questions)"
    if test.corrected < SIGNIFICANCE and test.strength >= MIN_STRENGTH:
        return Finding(test.check, test.task, "fails" if test.judged else "reported", f"{wrong} {how}")
    if not test.judged or test.check != "balance":
        verdict: Verdict = "holds" if test.judged else "reported"
        return Finding(test.check, test.task, verdict, f"{what} within the power of the test {how}")
    gain = f"{100 * guessing_gain(test):.0f} points above guessing"
    power = f"a strength of {test.least:.2f} would have been detected, {gain}"
    if guessing_gain(test) > MAX_MISSED_GAIN:
        return Finding(test.check, test.task, "unclear", f"{what} {how}; {power}: too few questions for a conclusion")
    return Finding(test.check, test.task, "holds", f"{what} {how}; {power}")


def _test(unit: Unit, first: str, second: str, judged: bool) -> Test:
    """Return the test of two variables."""
    cases = _independent(unit, first, second)
    (rows, a), (columns, b) = _codes(cases, first), _codes(cases, second)
    groups = np.unique([case.row["block"] for case in cases], return_inverse=True)[1]
    counts = tuple(tuple(map(int, row)) for row in contingency_table(a, b))
    strength, p, method, effect = dependence(a, b, groups)
    return Test(unit.name, first, second, rows, columns, counts, strength, p, method, judged, effect)


def _independent(unit: Unit, *names: str) -> Sequence[Case]:
    """Return the rows that are independent for these variables: one of a control group if all its rows agree."""
    combinations: dict[int, set[tuple[str, ...]]] = {}
    for case in unit.per_instance:
        combinations.setdefault(case.row["block"], set()).add(tuple(str(value_of(case, name)) for name in names))
    if len(combinations) < 2 or max(map(len, combinations.values())) > 1:
        return unit.per_instance
    return list({case.row["block"]: case for case in unit.per_instance}.values())


def _uniform(unit: Unit, what: str) -> Test:
    """Test whether every position, or every answer, is true as often as it is offered."""
    expected: Counter[str] = Counter()
    cases = _independent(unit, what)
    for case in cases:
        for value in _offered_values(case, what):
            expected[value] += 1 / case.count  # type: ignore[assignment]
    seen = Counter(value_of(case, what) for case in cases)
    values = tuple(sorted(expected, key=_order))
    counts = np.array([seen[v] for v in values])
    strength, p, method = goodness_of_fit(counts, np.array([expected[v] for v in values], dtype=np.float64))
    return Test(unit.name, what, "", ("",), values, (tuple(map(int, counts)),), strength, p, method, True)


def _offered_values(case: Case, what: str) -> list[str]:
    """Return the positions or answers that a case offers."""
    return [str(i + 1) for i in range(case.count)] if what == PLACE else list(case.row["option_name"])


def answers_by(cases: Sequence[Case], factor: str) -> Table:
    """Return counts of each answer (rows) for each level of a factor (columns)."""
    return contingency_table(_codes(cases, ANSWER)[1], _codes(cases, factor)[1])


def _codes(cases: Sequence[Case], what: str) -> tuple[tuple[str, ...], NDArray[np.intp]]:
    """Return the sorted values, and the index (n,) of each case's value."""
    return codes([value_of(case, what) for case in cases])


def codes(seen: Sequence[Any]) -> tuple[tuple[str, ...], NDArray[np.intp]]:
    """Return the sorted values as texts, and the index (n,) of each. Many numbers are binned (`MAX_VALUES`)."""
    binned = _bin(seen)
    values = tuple(sorted(set(binned), key=_order))
    number = {value: i for i, value in enumerate(values)}
    return values, np.array([number[value] for value in binned], np.intp)


def value_of(case: Case, what: str) -> Any:
    """Return the value of a factor or nuisance, the position of the truth (from 1), or the answer."""
    if what == PLACE:
        return str(case.row["answer"] + 1)
    if what != ANSWER:
        return (case.varied("nuisance") | case.varied("factor"))[what]
    if case.open:
        number = case.row["answer_number"]
        return case.row["answer_value"] if number is None else number
    return case.row["option_name"][case.row["answer"]]


def _bin(values: Sequence[Any]) -> list[str]:
    """Return values as text; numbers with many distinct values as their quarter or half."""
    numbers = [v for v in values if isinstance(v, (int, float)) and not isinstance(v, bool)]
    if len(numbers) < len(values) or len(set(numbers)) <= MAX_VALUES:
        return [f"{v:.4g}" if isinstance(v, float) else str(v) for v in values]
    edges = np.quantile(numbers, [0.25, 0.5, 0.75] if len(numbers) >= 4 * MIN_CASES else [0.5])
    bounds = [min(numbers), *edges, max(numbers)]
    ranges = [f"{a:.3g} to {b:.3g}" for a, b in pairwise(bounds)]
    return [ranges[int(np.searchsorted(edges, v))] for v in values]


def _order(range_: str) -> tuple[float, str]:
    """Sort key: numbers by size, then words."""
    try:
        return float(range_.partition(" to ")[0]), ""
    except ValueError:
        return float("inf"), range_
