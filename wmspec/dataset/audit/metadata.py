"""Tests of what stands beside a question: index, id, block, order of rows, lengths of texts and sizes of files.

None of it may tell the answer or the level of a crossed factor, which a public spec would let anyone read off a row.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from wmspec.dataset.audit.balance import ANSWER, PLACE, codes, value_of
from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.model import Test
from wmspec.dataset.audit.statistics import SEED, contingency_table, independence, pearson

CHECK = "metadata"
#: Remainders of numbers are tested by these divisors: the usual numbers of levels and of instances of a group.
DIVISORS = (2, 3, 4, 5, 6, 8)
#: Number of random permutations of the groups, and of the instances of each.
PERMUTATIONS = 1_999

_DIGITS = re.compile(r"(?<![^\W_])[0-9a-f]{4,}(?![^\W_])")

Codes = NDArray[np.intp]


def answer_tests(unit: Unit) -> list[Test]:
    """Return the tests of the answer: the strongest dependence on a number of the row, and on the sizes of the files.

    The sizes of the files shown are tested without judgement, since the pictures are meant to be seen.
    """
    if unit.open:
        return []
    cases = unit.per_instance
    what = PLACE if cases[0].has_picture_options else ANSWER
    texts = codes([len(case.row["text"].encode()) for case in cases])
    tested = [_strongest(unit, what, [*_numbers(cases), ("length of the text", *texts)], judged=True)]
    if cases[0].context_sizes:
        sizes = codes([sum(case.context_sizes) for case in cases])
        tested.append(_strongest(unit, what, [("size of the picture files", *sizes)], judged=False))
    return tested


def level_tests(unit: Unit) -> list[Test]:
    """Return the tests of the level of every crossed factor: the strongest dependence on a number of the row."""
    cases = unit.per_instance
    crossed = dict.fromkeys(name for case in cases for name in case.row["crossed"] or ())
    known = [name for name in crossed if all(name in case.varied("factor") for case in cases) and _varies(cases, name)]
    return [_strongest(unit, name, list(_numbers(cases)), judged=True) for name in known]


def _varies(cases: Sequence[Case], factor: str) -> bool:
    """Whether a factor varies within at least half of the groups. Others are constant in most, which are few."""
    levels: dict[int, set[str]] = {}
    for case in cases:
        levels.setdefault(case.row["block"], set()).add(str(case.varied("factor")[factor]))
    return sum(len(seen) > 1 for seen in levels.values()) >= len(levels) / 2


def _numbers(cases: Sequence[Case]) -> Iterator[tuple[str, tuple[str, ...], Codes]]:
    """Yield the numbers that identify a row, in quarters and as remainders: name, values, code of each case."""
    order = {case.row["index"]: place for place, case in enumerate(cases)}
    numbers: dict[str, Callable[[Case], int]] = {
        "index": lambda case: case.row["index"],
        "block": lambda case: case.row["block"],
        "order of the rows": lambda case: order[case.row["index"]],
        "id": _id_number,
    }
    for name, number in numbers.items():
        values = [number(case) for case in cases]
        yield name, *codes(values)
        for divisor in DIVISORS:
            yield f"{name} modulo {divisor}", *codes([str(value % divisor) for value in values])


def _id_number(case: Case) -> int:
    """Return the number in a row's id: of its longest run of hexadecimal digits, the last eight; 0 without any."""
    runs = _DIGITS.findall(case.row["id"].lower())
    return int(max(runs, key=len)[-8:], 16) if runs else 0


# ---------------------------------------------------------------- the test


def _strongest(unit: Unit, what: str, numbers: Sequence[tuple[str, tuple[str, ...], Codes]], judged: bool) -> Test:
    """Return the test of a value and the number that it depends on most.

    Its p-value is that of the smallest of all numbers, under random permutations of the groups and of the instances of
    each group. These keep what the design fixes: how often each level occurs in a group.
    """
    cases = unit.per_instance
    levels, level = codes([value_of(case, what) for case in cases])
    orders = _orders(np.unique([case.row["block"] for case in cases], return_inverse=True)[1])
    drawn = np.stack([(level == one)[orders].astype(np.float32) for one in range(len(levels))], axis=1)
    made = [_surprise(drawn, code) for _, _, code in numbers]  # the first order is the observed one
    smallest = np.min(made, axis=0)
    p = float((smallest <= smallest[0] * (1 + 1e-9)).mean())
    best = int(np.argmin([one[0] for one in made]))
    name, columns, code = numbers[best]
    table = contingency_table(level, code)
    label = what if what in (PLACE, ANSWER) else f"level of `{what}`"
    method = f"strongest of {len(numbers)}, {PERMUTATIONS:,} permutations"
    counts = tuple(tuple(map(int, row)) for row in table)
    return Test(unit.name, label, name, levels, columns, counts, independence(table)[0], p, method, judged, check=CHECK)


def _surprise(drawn: NDArray[np.float32], code: Codes) -> NDArray[np.float64]:
    """Return the chi-square p-value of the table of each permutation (permutations, levels, cases) with a number."""
    shown = np.eye(code.max() + 1, dtype=np.float32)[code]
    tables = (drawn.reshape(-1, len(code)) @ shown).reshape(*drawn.shape[:2], -1).astype(np.float64)
    freedom = (tables.shape[-1] - 1) * (tables.shape[-2] - 1)
    return np.asarray(stats.chi2.sf(pearson(tables), freedom)) if freedom else np.ones(len(tables))


def _orders(groups: Codes) -> NDArray[np.intp]:
    """Return permutations (1 + PERMUTATIONS, cases), the first of which changes nothing.

    Groups of one size change places, and so do the instances of each group.
    """
    random = np.random.default_rng(SEED)
    members = [np.flatnonzero(groups == group) for group in range(groups.max() + 1)]
    by_size: dict[int, NDArray[np.intp]] = {
        size: np.stack([m for m in members if len(m) == size]) for size in sorted({len(m) for m in members})
    }
    orders = np.tile(np.arange(len(groups)), (1 + PERMUTATIONS, 1))
    for order in orders[1:]:
        for places in by_size.values():
            order[places] = random.permuted(random.permutation(places), axis=1)
    return orders
