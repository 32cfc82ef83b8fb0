"""Balance: answers, the places of the true option and nuisances are independent of one another.

The answer may hang on the factors: that is what they are for. How much it does is told and not judged.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.audit.cases import Case, Unit
from wmspec.audit.model import Finding, Test
from wmspec.audit.statistics import detectable, goodness, holm, independence

#: Numbers with more different values than this are put into quarters.
MOST_VALUES = 8
#: A dependence fails if it is this sure after correction, and this strong: a weak one is no use to anybody.
SURE, STRONG = 0.01, 0.1
#: A test that could have overlooked a stronger dependence than this says nothing: it is large (Cohen 1988).
ROOM = 0.5

PLACE, ANSWER = "place of the truth", "answer"


@dataclass(frozen=True)
class Crossed:
    """Two things counted together: a row for each value of the first, a column for each of the second."""

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    counts: NDArray[np.int64]


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


def corrected(tested: Sequence[Test]) -> list[Test]:
    """The tests with their probabilities corrected for the number of those judged."""
    judged = iter(holm([t.p for t in tested if t.judged]))
    return [replace(t, corrected=next(judged) if t.judged else t.p) for t in tested]


def powered(tested: Sequence[Test]) -> list[Test]:
    """The tests with the weakest dependence that each would have found, given how many are judged."""
    level = SURE / max(1, sum(t.judged for t in tested))
    return [replace(t, least=detectable(t.counts, level)) for t in tested]


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
    power = f"a strength of {test.least:.2f} would have been found"
    if test.least > ROOM:
        return Finding("balance", test.task, "unclear", f"{what} {how}; {power}: too few questions to tell")
    return Finding("balance", test.task, "holds", f"{what} {how}; {power}")


def _tested(unit: Unit, first: str, second: str, judged: bool) -> Test:
    table = table_of(_independent(unit, first, second), second, first)
    strength, p, method = independence(table.counts)
    counts = tuple(tuple(map(int, row)) for row in table.counts)
    return Test(unit.name, first, second, table.rows, table.columns, counts, strength, p, method, judged)


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


def table_of(cases: Sequence[Case], second: str, first: str = ANSWER) -> Crossed:
    """`first` (a row each) against `second` (a column each): a factor's or nuisance's values, or the answer's."""
    a, b = (_binned([_value(c, what) for c in cases]) for what in (first, second))
    rows, columns = (tuple(sorted(set(values), key=_order)) for values in (a, b))
    counts = np.zeros((len(rows), len(columns)), dtype=np.int64)
    for x, y in zip(a, b, strict=True):
        counts[rows.index(x), columns.index(y)] += 1
    return Crossed(rows, columns, counts)


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
    """Values as texts; many different numbers as the quarter that they are in."""
    numbers = [v for v in values if isinstance(v, (int, float)) and not isinstance(v, bool)]
    if len(numbers) < len(values) or len(set(numbers)) <= MOST_VALUES:
        return [f"{v:.4g}" if isinstance(v, float) else str(v) for v in values]
    edges = np.quantile(numbers, [0.25, 0.5, 0.75])
    bounds = [min(numbers), *edges, max(numbers)]
    ranges = [f"{a:.3g} to {b:.3g}" for a, b in pairwise(bounds)]
    return [ranges[int(np.searchsorted(edges, v))] for v in values]


def _order(range_: str) -> tuple[float, str]:
    """Numbers by size, then words."""
    try:
        return float(range_.partition(" to ")[0]), ""
    except ValueError:
        return float("inf"), range_
