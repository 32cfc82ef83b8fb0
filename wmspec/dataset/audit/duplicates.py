"""Duplicates: questions asked twice, and questions that say true what another of the same looks says false."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit.cases import SIDE, Case, Small, Unit
from wmspec.dataset.audit.model import Finding
from wmspec.runtime.questions.bearing import Bearing

#: Two pixels of small pictures differ if a channel differs by more than this (of 255).
LEAST_STEP = 8
#: Pictures in which fewer pixels than this share differ look alike: as many as a question's own options must differ in.
ALIKE = 100 / 256**2
#: Two pixels of pictures at their own size differ if a channel differs by more than this (of 255), and pictures that
#: look alike when small are told apart if so many do: as many as show what can be asked about.
FAINT_STEP, FAINT = 3, 36 / 256**2
#: So many pairs are in memory at once at their own size.
AT_ONCE = 16
#: Candidates for a comparison differ by at most this in the mean of a channel over a ninth of a picture (of 255).
COARSE = 4.0
#: The most examples that a finding names.
MOST_NAMED = 3


@dataclass(frozen=True)
class Pair:
    """Two questions that ask the same: exactly, or to the eye; `contrary` if they do not have the same answer.

    Contrary ones that only look so when small are `faint`: at their own size their pictures can be told apart.
    """

    first: str
    second: str
    exact: bool
    contrary: bool
    faint: bool = False


#: The pictures shown of some instances at their own size, by the row's name.
Enlarged = Callable[[set[int]], Mapping[str, Sequence[Small]]]


def duplicates(unit: Unit) -> list[Pair]:
    """The pairs of a unit's questions that ask the same."""
    pairs = [*_exact(unit.cases)]
    known = {(p.first, p.second) for p in pairs}
    return pairs + [p for p in _near(unit.first_engine) if (p.first, p.second) not in known]


def enlarged(unit: Unit, pairs: Sequence[Pair], pictures: Enlarged) -> list[Pair]:
    """The pairs, of which the contrary ones that can be told apart at their own size are marked as faint."""
    index = {case.row["id"]: case.row["index"] for case in unit.cases}
    near = [p for p in pairs if p.contrary and not p.exact]
    faint = set[Pair]()
    for some in (near[i : i + AT_ONCE] for i in range(0, len(near), AT_ONCE)):
        shown = pictures({index[name] for p in some for name in (p.first, p.second)})
        faint |= {p for p in some if any(map(_parted, shown[p.first], shown[p.second]))}
    return [replace(p, faint=p in faint) for p in pairs]


def _parted(a: Small, b: Small) -> bool:
    return float((abs(a.astype(np.int16) - b) > FAINT_STEP).any(-1).mean()) >= FAINT


def judged(unit: Unit, pairs: Sequence[Pair]) -> list[Finding]:
    """What there is to say about them: contrary pairs fail, unless they are faint; others are told."""
    contrary, same = [p for p in pairs if p.contrary and not p.faint], [p for p in pairs if not p.contrary]
    findings = []
    if faint := [p for p in pairs if p.faint]:
        what = f"{_count(faint)} can be told apart by who enlarges their pictures alone, such as {_named(faint)}"
        findings.append(Finding("duplicates", unit.name, "told", what))
    if contrary:
        what = f"{_count(contrary)} ask the same and have different answers, such as {_named(contrary)}"
        findings.append(Finding("duplicates", unit.name, "fails", what))
    if same:
        exact = sum(p.exact for p in same)
        what = f"{_count(same)} ask the same and have the same answer ({exact:,} to the byte), such as {_named(same)}"
        findings.append(Finding("duplicates", unit.name, "told", what))
    if not pairs:
        seen = len(unit.first_engine)
        what = f"none among {len(unit.cases):,} rows to the byte, none among {seen:,} instances to the eye"
        findings.append(Finding("duplicates", unit.name, "holds", what))
    return findings


def _count(pairs: Sequence[Pair]) -> str:
    return f"{len(pairs):,} {'pair' if len(pairs) == 1 else 'pairs'} of questions"


def _named(pairs: Sequence[Pair]) -> str:
    return ", ".join(f"{p.first} and {p.second}" for p in pairs[:MOST_NAMED])


# ---------------------------------------------------------------- to the byte


def _exact(cases: Sequence[Case]) -> Iterator[Pair]:
    """Pairs with the same words and the same pictures shown, in any engine; each with the first of its kind."""
    first: dict[tuple[object, ...], list[Case]] = defaultdict(list)
    for case in cases:
        key = (case.row["text"], case.context, tuple(case.row["context_camera"]), tuple(case.row["context_time"]))
        for other in first[key]:
            if other.row["index"] != case.row["index"] and _offers_the_same(other, case):
                yield Pair(other.row["id"], case.row["id"], True, _true(case) != _true(other))
                break
        else:
            first[key].append(case)


def _offers_the_same(a: Case, b: Case) -> bool:
    return a.open or sorted(_options(a)) == sorted(_options(b)) or _true(a) in _options(b) or _true(b) in _options(a)


def _options(case: Case) -> tuple[bytes, ...]:
    return case.options or tuple(text.encode() for text in case.row["option_text"] or ())


def _true(case: Case) -> bytes:
    return str(case.row["answer_value"]).encode() if case.open else _options(case)[case.row["answer"]]


# ---------------------------------------------------------------- to the eye


def _near(cases: Sequence[Case]) -> Iterator[Pair]:
    """Pairs of the same engine with the same words and pictures that look alike, where one can answer the other."""
    parted: dict[tuple[object, ...], list[Case]] = defaultdict(list)
    for case in cases:
        parted[(case.row["text"], case.pictured, len(case.seen_context))].append(case)
    for alike in parted.values():
        for a, b in _candidates(alike):
            if not all(map(looks_alike, a.seen_context, b.seen_context)):
                continue
            if _same_answer(a, b):
                yield Pair(a.row["id"], b.row["id"], False, False)
            elif _denies(a, b) or _denies(b, a):
                yield Pair(a.row["id"], b.row["id"], False, True)


def _candidates(cases: Sequence[Case]) -> Iterator[tuple[Case, Case]]:
    """Pairs whose pictures have about the same colours everywhere: a quick look that misses none that look alike."""
    if not cases or not cases[0].seen_context:
        yield from combinations(cases, 2)
        return
    coarse = np.stack([np.concatenate([_coarse(p) for p in c.seen_context]) for c in cases])
    for i, here in enumerate(coarse[:-1]):
        gap = abs(coarse[i + 1 :] - here).max(1)
        yield from ((cases[i], cases[i + 1 + int(j)]) for j in np.flatnonzero(gap <= COARSE))


def _coarse(picture: Small) -> NDArray[np.float32]:
    third = SIDE // 3
    return np.asarray(picture.reshape(3, third, 3, third, 3).mean((1, 3), dtype=np.float32).ravel())


def different(a: Small, b: Small) -> float:
    """The share of pixels in which two small pictures differ."""
    return float((abs(a.astype(np.int16) - b) > LEAST_STEP).any(-1).mean())


def looks_alike(a: Small, b: Small) -> bool:
    """Whether nobody could tell two small pictures apart."""
    return different(a, b) < ALIKE


def _same_answer(a: Case, b: Case) -> bool:
    if a.pictured:
        return looks_alike(a.seen_options[a.row["answer"]], b.seen_options[b.row["answer"]])
    within: float | None = a.row.get("answer_within")  # of an open question about a number
    if within is None:
        return _true(a) == _true(b)
    apart = a.row["answer_number"] - b.row["answer_number"]
    return bool(abs(Bearing(apart) if a.row["answer_unit"] == "rad" else apart) <= within)


def _denies(a: Case, b: Case) -> bool:
    """Whether what is true in `a` is an option of `b` that is false."""
    if not a.pictured:
        return a.open or _true(a) in _options(b)
    true = a.seen_options[a.row["answer"]]
    return any(looks_alike(true, o) for i, o in enumerate(b.seen_options) if i != b.row["answer"])
