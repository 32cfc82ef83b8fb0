"""Balance: answers, the places of the true option and nuisances are independent of one another.

The answer may hang on the factors: that is what they are for. How much it does is told and not judged.
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
from wmspec.dataset.audit.model import Finding, Test
from wmspec.dataset.audit.statistics import Table, crossed, dependence, detectable, goodness, holm

#: Numbers with more different values than this are put into quarters; into halves, if a quarter had fewer cases.
MOST_VALUES, LEAST_CASES = 8, 20
#: A dependence fails if it is this sure after correction, and this strong: a weak one is no use to anybody.
SURE, STRONG = 0.01, 0.1
#: A test that could have overlooked what makes guessing better by more than this says nothing.
ROOM = 0.35

PLACE, ANSWER = "place of the truth", "answer"


def tests(unit: Unit) -> list[Test]:
    """All tests of a unit's questions, one row for each instance."""
    first = unit.once[0]
    factors, nuisances = first.varied("factor"), first.varied("nuisance")
    made = []
    if not first.pictured:
        made += [_tested(unit, ANSWER, n, True) for n in nuisances]
        made += [_tested(unit, ANSWER, f, False) for f in factors]
    if not first.open:
        made += [_uniform(unit, PLACE), *(_tested(unit, PLACE, n, True) for n in (*factors, *nuisances))]
    if not first.open and not first.pictured:
        made += [_uniform(unit, ANSWER), _tested(unit, PLACE, ANSWER, True)]
    return made


def weighed(tested: Sequence[Test]) -> list[Test]:
    """The tests with their probabilities corrected, and with the weakest dependence that each would have found.

    Of a task, those of answers are one family and those of the places of the truth another, so that the many of places
    take nothing from the few of answers, which have one case in each group. Each family has half of the alarms.
    """
    families: dict[tuple[str, str], list[int]] = {}
    for i, test in enumerate(tested):
        if test.judged:
            families.setdefault((task_of(test.task), test.first), []).append(i)
    made = [
        test if test.judged else replace(test, corrected=test.p, least=detectable(test.counts, SURE, test.effect))
        for test in tested
    ]
    for family in families.values():
        level = SURE / 2 / len(family)
        for i, p in zip(family, holm([tested[i].p for i in family]), strict=True):
            made[i] = replace(
                tested[i], corrected=min(1.0, 2 * p), least=detectable(tested[i].counts, level, tested[i].effect)
            )
    return made


def points(test: Test) -> float:
    """How much better than guessing is who knows the weakest dependence that would have been found (0 to 1).

    That is if it tells all about as many cases as it takes, and nothing about the others.
    """
    rows, columns = sum(map(any, test.counts)), sum(map(any, zip(*test.counts, strict=True)))
    if not test.second:  # one of them is true more often, the others less
        return min(1.0, test.least * sqrt(max(0, columns - 1)) / max(1, columns))
    return test.least * (min(rows, columns) - 1) / rows


def judge(test: Test) -> Finding:
    """What a test says about its task."""
    asked = sum(map(sum, test.counts))
    what = f"{test.first} and {test.second} are independent" if test.second else f"the {test.first} is uniform"
    wrong = f"{test.first} goes with {test.second}" if test.second else f"the {test.first} is not uniform"
    how = f"({test.method}, p = {test.corrected:.2g}, strength {test.strength:.2f}, {asked:,} questions)"
    if test.corrected < SURE and test.strength >= STRONG:
        return Finding("balance", test.task, "fails" if test.judged else "told", f"{wrong} {how}")
    if not test.judged:
        return Finding("balance", test.task, "told", f"{what}, as far as can be told {how}")
    power = f"a strength of {test.least:.2f} would have been found, {100 * points(test):.0f} points above guessing"
    if points(test) > ROOM:
        return Finding("balance", test.task, "unclear", f"{what} {how}; {power}: too few questions to tell")
    return Finding("balance", test.task, "holds", f"{what} {how}; {power}")


def _tested(unit: Unit, first: str, second: str, judged: bool) -> Test:
    cases = _independent(unit, first, second)
    (rows, a), (columns, b) = _coded(cases, first), _coded(cases, second)
    groups = np.unique([case.row["block"] for case in cases], return_inverse=True)[1]
    counts = tuple(tuple(map(int, row)) for row in crossed(a, b))
    strength, p, method, effect = dependence(a, b, groups)
    return Test(unit.name, first, second, rows, columns, counts, strength, p, method, judged, effect)


def _independent(unit: Unit, *names: str) -> Sequence[Case]:
    """The rows that tell something new of these: one of each control group, if all of its rows say the same."""
    combinations: dict[int, set[tuple[str, ...]]] = {}
    for case in unit.once:
        combinations.setdefault(case.row["block"], set()).add(tuple(str(_value(case, name)) for name in names))
    if len(combinations) < 2 or max(map(len, combinations.values())) > 1:
        return unit.once
    return list({case.row["block"]: case for case in unit.once}.values())


def _uniform(unit: Unit, what: str) -> Test:
    """Whether every place, or every answer, is true as often as it is on offer."""
    expected: Counter[str] = Counter()
    cases = _independent(unit, what)
    for case in cases:
        for value in _offered(case, what):
            expected[value] += 1 / case.count  # type: ignore[assignment]
    seen = Counter(_value(case, what) for case in cases)
    values = tuple(sorted(expected, key=_order))
    counts = np.array([seen[v] for v in values])
    strength, p, method = goodness(counts, np.array([expected[v] for v in values], dtype=np.float64))
    return Test(unit.name, what, "", ("",), values, (tuple(map(int, counts)),), strength, p, method, True)


def _offered(case: Case, what: str) -> list[str]:
    return [str(i + 1) for i in range(case.count)] if what == PLACE else list(case.row["option_name"])


def answers_by(cases: Sequence[Case], factor: str) -> Table:
    """How often each answer, a row, comes with each level of a factor."""
    return crossed(_coded(cases, ANSWER)[1], _coded(cases, factor)[1])


def _coded(cases: Sequence[Case], what: str) -> tuple[tuple[str, ...], NDArray[np.intp]]:
    """The values, in order, and the number (n,) of the one that each case has."""
    binned = _binned([_value(case, what) for case in cases])
    values = tuple(sorted(set(binned), key=_order))
    number = {value: i for i, value in enumerate(values)}
    return values, np.array([number[value] for value in binned], np.intp)


def _value(case: Case, what: str) -> Any:
    """The value of a factor or nuisance, the place of the truth (from 1), or the answer."""
    if what == PLACE:
        return str(case.row["answer"] + 1)
    if what != ANSWER:
        return (case.varied("nuisance") | case.varied("factor"))[what]
    if case.open:
        number = case.row["answer_number"]
        return case.row["answer_value"] if number is None else number
    return case.row["option_name"][case.row["answer"]]


def _binned(values: Sequence[Any]) -> list[str]:
    """Values as texts; many different numbers as the quarter, or half, that they are in."""
    numbers = [v for v in values if isinstance(v, (int, float)) and not isinstance(v, bool)]
    if len(numbers) < len(values) or len(set(numbers)) <= MOST_VALUES:
        return [f"{v:.4g}" if isinstance(v, float) else str(v) for v in values]
    edges = np.quantile(numbers, [0.25, 0.5, 0.75] if len(numbers) >= 4 * LEAST_CASES else [0.5])
    bounds = [min(numbers), *edges, max(numbers)]
    ranges = [f"{a:.3g} to {b:.3g}" for a, b in pairwise(bounds)]
    return [ranges[int(np.searchsorted(edges, v))] for v in values]


def _order(range_: str) -> tuple[float, str]:
    """Numbers by size, then words."""
    try:
        return float(range_.partition(" to ")[0]), ""
    except ValueError:
        return float("inf"), range_
