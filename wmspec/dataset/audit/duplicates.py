"""Duplicates: repeated questions, and questions that look equal but have contrary answers.

Without those of other groups, the control groups that are left are independent: the effective sample size.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit.cases import THUMBNAIL_SIZE, Case, Thumbnail, Unit
from wmspec.dataset.audit.model import Finding
from wmspec.runtime.questions.bearing import Bearing

#: Thumbnail pixels differ if a channel differs by more than this (of 255).
MIN_PIXEL_STEP = 8
#: Thumbnails look alike if a smaller share of pixels differs; options of a question must differ in as many.
ALIKE_SHARE = 100 / 256**2
#: Full-size pixels differ if a channel differs by more than the first (of 255). Pictures that look alike as thumbnails
#: are distinguishable if at least the second share of pixels differs, which is the area of the smallest visible object.
FULL_SIZE_STEP, FULL_SIZE_SHARE = 3, 36 / 256**2
#: Number of full-size pairs in memory.
PAIRS_IN_MEMORY = 16
#: Maximum difference of a channel's mean over a ninth of a picture (of 255) for a pair to be compared.
MAX_COARSE_GAP = 4.0
#: Maximum number of examples in a finding.
MAX_EXAMPLES = 3
#: Minimum number of groups for conclusions about the task as a whole.
MIN_GROUPS = 30


@dataclass(frozen=True)
class Pair:
    """Two questions that are the same, exactly or visually; `contrary` if their answers differ.

    Contrary pairs that are distinguishable at full size are `faint`.
    """

    first: str
    second: str
    exact: bool
    contrary: bool
    faint: bool = False


#: Returns the full-size pictures of instances by row id.
ReadFullSize = Callable[[set[int]], Mapping[str, Sequence[Thumbnail]]]


def duplicates(unit: Unit) -> list[Pair]:
    """Return the pairs of a unit's questions that are the same."""
    pairs = [*_exact_pairs(unit.cases)]
    known = {(p.first, p.second) for p in pairs}
    return pairs + [p for p in _visual_pairs(unit.first_engine) if (p.first, p.second) not in known]


def mark_faint(unit: Unit, pairs: Sequence[Pair], pictures: ReadFullSize) -> list[Pair]:
    """Return the pairs, with contrary ones marked as faint if they are distinguishable at full size."""
    index = {case.row["id"]: case.row["index"] for case in unit.cases}
    near = [p for p in pairs if p.contrary and not p.exact]
    faint = set[Pair]()
    for some in (near[i : i + PAIRS_IN_MEMORY] for i in range(0, len(near), PAIRS_IN_MEMORY)):
        shown = pictures({index[name] for p in some for name in (p.first, p.second)})
        for p in some:
            looks = zip(shown[p.first], shown[p.second], strict=False)
            if any(pixel_difference(a, b, FULL_SIZE_STEP) >= FULL_SIZE_SHARE for a, b in looks):
                faint.add(p)
    return [replace(p, faint=p in faint) for p in pairs]


def duplicate_findings(unit: Unit, pairs: Sequence[Pair]) -> list[Finding]:
    """Return the findings. Contrary pairs fail unless they are faint; others are only reported."""
    contrary, same = [p for p in pairs if p.contrary and not p.faint], [p for p in pairs if not p.contrary]
    findings = []
    if faint := [p for p in pairs if p.faint]:
        what = f"{_count(faint)} are distinguishable only at full picture size, such as {_examples(faint)}"
        findings.append(Finding("duplicates", unit.name, "reported", what))
    if contrary:
        what = f"{_count(contrary)} are equal and have different answers, such as {_examples(contrary)}"
        findings.append(Finding("duplicates", unit.name, "fails", what))
    if same:
        exact = sum(p.exact for p in same)
        what = f"{_count(same)} are equal and have the same answer ({exact:,} to the byte), such as {_examples(same)}"
        findings.append(Finding("duplicates", unit.name, "reported", what))
    if not pairs:
        seen = len(unit.first_engine)
        what = f"none among {len(unit.cases):,} rows to the byte, none among {seen:,} instances to the eye"
        findings.append(Finding("duplicates", unit.name, "holds", what))
    return findings


def _count(pairs: Sequence[Pair]) -> str:
    return f"{len(pairs):,} {'pair' if len(pairs) == 1 else 'pairs'} of questions"


def _examples(pairs: Sequence[Pair]) -> str:
    return ", ".join(f"{p.first} and {p.second}" for p in pairs[:MAX_EXAMPLES])


def effective_groups(unit: Unit, pairs: Sequence[Pair]) -> int:
    """Return the number of control groups with at least one question that no earlier group has, exactly or visually."""
    block = {case.row["id"]: case.row["block"] for case in unit.cases}
    again = {max(p.first, p.second) for p in pairs if block[p.first] != block[p.second]}
    return len({b for name, b in block.items() if name not in again})


def group_finding(unit: Unit, count: int) -> Finding:
    """Return whether there are enough groups for conclusions about the task rather than about a few scenes."""
    again = unit.draws - count
    what = f"{len(unit.per_instance):,} instances of {count:,} independent groups" + (
        f", {again:,} are duplicates" if again else ""
    )
    if count >= MIN_GROUPS:
        return Finding("groups", unit.name, "holds", what)
    return Finding("groups", unit.name, "unclear", f"{what}; {MIN_GROUPS} are needed for conclusions about the task")


# ---------------------------------------------------------------- exact


def _exact_pairs(cases: Sequence[Case]) -> Iterator[Pair]:
    """Yield pairs with equal words and pictures in any engine, each with the first of its kind."""
    first: dict[tuple[object, ...], list[Case]] = defaultdict(list)
    for case in cases:
        key = (case.row["text"], case.context, tuple(case.row["context_camera"]), tuple(case.row["context_time"]))
        for other in first[key]:
            if other.row["index"] != case.row["index"] and _offers_the_same(other, case):
                yield Pair(other.row["id"], case.row["id"], True, _true_option(case) != _true_option(other))
                break
        else:
            first[key].append(case)


def _offers_the_same(a: Case, b: Case) -> bool:
    return (
        a.open
        or sorted(_options(a)) == sorted(_options(b))
        or _true_option(a) in _options(b)
        or _true_option(b) in _options(a)
    )


def _options(case: Case) -> tuple[bytes, ...]:
    return case.options or tuple(text.encode() for text in case.row["option_text"] or ())


def _true_option(case: Case) -> bytes:
    return str(case.row["answer_value"]).encode() if case.open else _options(case)[case.row["answer"]]


# ---------------------------------------------------------------- visual


def _visual_pairs(cases: Sequence[Case]) -> Iterator[Pair]:
    """Yield pairs of one engine with equal words and similar pictures where one answer applies to the other."""
    parted: dict[tuple[object, ...], list[Case]] = defaultdict(list)
    for case in cases:
        parted[(case.row["text"], case.has_picture_options, len(case.context_thumbnails))].append(case)
    for alike in parted.values():
        for a, b in _candidates(alike):
            if not all(map(looks_alike, a.context_thumbnails, b.context_thumbnails)):
                continue
            if _same_answer(a, b):
                yield Pair(a.row["id"], b.row["id"], False, False)
            elif _contradicts(a, b) or _contradicts(b, a):
                yield Pair(a.row["id"], b.row["id"], False, True)


def _candidates(cases: Sequence[Case]) -> Iterator[tuple[Case, Case]]:
    """Yield pairs with similar mean colours everywhere: a fast filter without false negatives."""
    if not cases or not cases[0].context_thumbnails:
        yield from combinations(cases, 2)
        return
    coarse = np.stack([np.concatenate([_coarse(p) for p in c.context_thumbnails]) for c in cases])
    for i, here in enumerate(coarse[:-1]):
        gap = abs(coarse[i + 1 :] - here).max(1)
        yield from ((cases[i], cases[i + 1 + int(j)]) for j in np.flatnonzero(gap <= MAX_COARSE_GAP))


def _coarse(picture: Thumbnail) -> NDArray[np.float32]:
    third = THUMBNAIL_SIZE // 3
    return np.asarray(picture.reshape(3, third, 3, third, 3).mean((1, 3), dtype=np.float32).ravel())


def pixel_difference(a: Thumbnail, b: Thumbnail, step: int = MIN_PIXEL_STEP) -> float:
    """Return the share of pixels in which two pictures differ: a channel by more than `step` (of 255)."""
    return float((abs(a.astype(np.int16) - b) > step).any(-1).mean())


def looks_alike(a: Thumbnail, b: Thumbnail) -> bool:
    """Whether two thumbnails are indistinguishable."""
    return pixel_difference(a, b) < ALIKE_SHARE


def _same_answer(a: Case, b: Case) -> bool:
    if a.has_picture_options:
        return looks_alike(a.option_thumbnails[a.row["answer"]], b.option_thumbnails[b.row["answer"]])
    within: float | None = a.row.get("answer_within")  # set for open questions about a number
    if within is None:
        return _true_option(a) == _true_option(b)
    apart = a.row["answer_number"] - b.row["answer_number"]
    return bool(abs(Bearing(apart) if a.row["answer_unit"] == "rad" else apart) <= within)


def _contradicts(a: Case, b: Case) -> bool:
    """Whether the true option of `a` is a false option of `b`."""
    if not a.has_picture_options:
        return a.open or _true_option(a) in _options(b)
    true = a.option_thumbnails[a.row["answer"]]
    return any(looks_alike(true, o) for i, o in enumerate(b.option_thumbnails) if i != b.row["answer"])
