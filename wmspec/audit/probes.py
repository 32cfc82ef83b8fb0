"""Shortcut probes: can a question be answered from less than what it shows?

A probe that sees none of the pictures shown must stay at chance. One that sees a single of them must too, if the
question shows several moments and is about what happens: no single moment holds that. If all its pictures are of one
moment, or it asks for what holds from the start, it is meant to be answered from one, and the probe is told but not
judged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from wmspec.audit import features
from wmspec.audit.balance import table_of
from wmspec.audit.cases import Case, Unit
from wmspec.audit.classify import held_out
from wmspec.audit.model import Finding, Probe
from wmspec.audit.statistics import clopper_pearson, independence

#: A probe fails if all of its interval is more than this above chance.
SLACK = 0.05
#: An interval that reaches further than this above chance cannot exclude a shortcut: there are too few questions.
ROOM = 0.15
#: The intervals of all probes judged hold together with this confidence.
CONFIDENCE = 0.95
#: Fewer questions, or groups of them, are not worth fitting to.
LEAST_ASKED, LEAST_GROUPS = 20, 5

See = Callable[[Sequence[Case]], NDArray[np.float64]]

_BLIND = "it sees none of the pictures"
_MOMENT = "it sees one moment of several"
_STILL = "the question shows one moment, so a picture of it may suffice"
_STANDING = "the answer holds from the start, so a picture of any moment may suffice"
_NOTHING = "the question shows no picture, so its options are all there is"


def probes(unit: Unit) -> list[Probe]:
    """Every probe that the unit's questions allow; none if there are too few of them, or nothing to choose from."""
    cases = _alike(unit.looked_at)
    if len(cases) < LEAST_ASKED or cases[0].open:
        return []
    groups = _groups(unit, cases)
    if len(set(groups)) < LEAST_GROUPS:
        return []
    owner = np.repeat(np.arange(len(cases)), [c.count for c in cases])
    truth = np.concatenate([np.arange(c.count) == c.row["answer"] for c in cases])
    chance = float(np.mean([1 / c.count for c in cases]))
    made = []
    for name, see, judged, why in _kinds(cases[0]):
        right = held_out(see(cases), owner, truth, groups)
        made.append(Probe(unit.name, name, len(cases), float(right.sum()), chance, judged, why))
    return made


def _kinds(case: Case) -> Iterator[tuple[str, See, bool, str]]:
    """The probes for questions such as this: what each sees, and whether and why it is judged."""
    shown, several = len(case.seen_context), case.moments > 1
    blind, one = (bool(shown), _BLIND if shown else _NOTHING), (several, _MOMENT if several else _STILL)
    if several and case.row["answer_standing"]:
        one = False, _STANDING
    yield "the place of the options", features.positions, True, _BLIND
    yield "the text", features.texts, True, _BLIND
    yield "the options", features.options, *blind
    if case.pictured:
        yield "the options' colours", features.colours, *blind
    for which, name in {0: "the first picture", shown - 1: "the last picture"}.items() if shown else ():
        seen_as = "the picture" if shown == 1 else name
        yield seen_as, features.pixels(which), *one
        yield f"{seen_as}'s colours", features.tones(which), *one


def _alike(cases: Sequence[Case]) -> list[Case]:
    """The cases of the commonest form: as many pictures, and options of one kind."""
    forms = [(c.pictured, c.open, len(c.seen_context)) for c in cases]
    common = max(forms, key=forms.count, default=None)
    return [c for c, form in zip(cases, forms, strict=True) if form == common]


def _groups(unit: Unit, cases: Sequence[Case]) -> list[str]:
    """The control group of each case: the instances that differ in nothing but the factor on which the answer hangs.

    Its members look alike and have different answers; some to fit to and some to judge by would mislead the classifier.
    Repetitions and engines are of one group too: they would give the answer away.
    """
    names = list(cases[0].varied("factor")) if not cases[0].pictured else []
    decides = max(names, key=lambda n: independence(table_of(unit.once, n).counts)[0], default="")
    return ["/".join(f"{n}={v}" for n, v in c.varied("factor").items() if n != decides) or c.row["id"] for c in cases]


def intervals(made: Sequence[Probe]) -> list[Probe]:
    """The probes with their intervals, as wide as the number of those judged asks for (Bonferroni)."""
    confidence = 1 - (1 - CONFIDENCE) / max(1, sum(p.judged for p in made))
    return [
        replace(p, low=low, high=high) for p in made for low, high in [clopper_pearson(p.right, p.asked, confidence)]
    ]


def judge(probe: Probe) -> Finding:
    """What a probe says about its task."""
    result = (
        f"from {probe.sees} alone, {probe.accuracy:.0%} of {probe.asked:,} answered "
        f"({probe.low:.0%} to {probe.high:.0%}; chance {probe.chance:.0%})"
    )
    if not probe.judged:
        return Finding("shortcut", probe.task, "told", f"{result}; {probe.why}")
    if probe.low > probe.chance + SLACK:
        return Finding("shortcut", probe.task, "fails", f"{result}; {probe.why}")
    if probe.high > probe.chance + ROOM:
        return Finding("shortcut", probe.task, "unclear", f"{result}; too few questions to tell")
    return Finding("shortcut", probe.task, "holds", result)
