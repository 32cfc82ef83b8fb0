"""Shortcut probes: can a question be answered from less than it takes?

A probe that sees none of the pictures shown must stay at chance. So must one that sees fewer moments than it takes to
see the answer: one, of a question about what changes; two, of one about the course of things. Of the many that see one
picture, or two, the best is judged (`wmspec.dataset.audit.probe_selection`). What sees more is told and not judged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit import features, image_similarity, power, state
from wmspec.dataset.audit.balance import answers_by
from wmspec.dataset.audit.cases import Case, Unit, task_of
from wmspec.dataset.audit.classify import Array, Asked, Seen, held_out, hits
from wmspec.dataset.audit.model import Finding, Probe
from wmspec.dataset.audit.probe_selection import Rivals
from wmspec.dataset.audit.statistics import clopper_pearson, independence

#: A shortcut is worth mending if it is more than this above chance: of what sees no picture, of what sees some.
SLACK, SLACK_SEEN = 0.05, 0.12
#: A probe that could have overlooked a larger shortcut than this says nothing: there are too few questions.
ROOM = 0.3
#: Fewer questions, or groups of them, are not worth fitting to.
LEAST_ASKED, LEAST_GROUPS = 20, 5

Of = Literal["options", "questions"]
See = Callable[[Sequence[Case]], Array]
SeeViews = Callable[[Sequence[Case], Sequence[int]], Array]
Look = Callable[[], Seen]
Family = Literal["text", "options", "rule", "picture", "pair", "pictures"]

#: What the best of these is called.
_BEST = {"picture": "single picture", "pair": "pair of pictures"}

_BLIND = "it sees none of the pictures"
_FEWER = "it takes more moments than it sees"
_ENOUGH = "it takes no more moments than it sees"
_NOTHING = "the question shows no picture, so its options are all there is"
_FRAMED = "options that differ in the action alone begin at one place, so that how far it has come shows in one picture"
_RIVAL = "the best of them is judged"
_UNASKED = "without the question, any of what is shown may be meant"


@dataclass(frozen=True)
class _Line:
    """A probe to be made. What it sees is worked out when it is its turn."""

    sees: str
    family: Family
    judged: bool
    why: str
    seen: Look | None = None
    scores: Array | None = None  # of a rule, which learns nothing
    pictured: bool = False  # whether it sees a picture shown, and may strike out options (`state.struck_out`)
    rival: bool = False  # whether it is one of those of which the best is judged


def probes(unit: Unit) -> list[Probe]:
    """Every probe that the unit's questions allow; none if there are too few of them, or nothing to choose from."""
    cases = _alike(unit.looked_at)
    if len(cases) < LEAST_ASKED or cases[0].open:
        return []
    groups = _groups(unit, cases)
    if len(set(groups)) < LEAST_GROUPS:
        return []
    task, lines = _Task(unit.name, cases, groups), list(_lines(cases))
    made = [task.probe(line) for line in lines if not line.rival]
    for family in dict.fromkeys(line.family for line in lines if line.rival):
        made += task.rivals(family, [line for line in lines if line.rival and line.family == family])
    return made


class _Task:
    """The questions of a task that are probed."""

    def __init__(self, name: str, cases: Sequence[Case], groups: Sequence[str]) -> None:
        self._name, self._cases, self._groups = name, cases, groups
        everything, struck = [np.zeros(c.count, dtype=bool) for c in cases], state.struck_out(cases)
        self._kept = ~np.concatenate(struck)
        self._asked = {False: _asked(cases, groups, everything), True: _asked(cases, groups, struck)}

    def probe(self, line: _Line) -> Probe:
        """What a probe answers of the questions."""
        asked = self._asked[line.pictured]
        if line.scores is not None:
            scores = line.scores[self._kept] if line.pictured else line.scores
            return self._probe(line, hits(scores, asked))
        seen = self._seen(line)
        learned = power.learned(seen, asked, 1 / asked.sizes) if line.judged else None
        return self._probe(line, held_out(seen, asked), learned)

    def rivals(self, family: Family, lines: Sequence[_Line]) -> list[Probe]:
        """What each of these probes answers, and the best of them."""
        # Shortcuts are planted into the same features again and again: few numbers, dear to work out.
        asked, seen = self._asked[True], [cache(partial(self._seen, line)) for line in lines]
        rivals = Rivals.of(seen, asked)
        right, picked = rivals.best(asked)
        commonest = lines[int(np.bincount(picked).argmax())].sees
        best = _Line(f"the best {_BEST[family]} ({commonest})", family, True, _FEWER, pictured=True)
        learned = rivals.learned(seen, asked, 1 / asked.sizes)
        each = [self._probe(line, answered) for line, answered in zip(lines, rivals.right, strict=True)]
        return [*each, self._probe(best, right, learned)]

    def _seen(self, line: _Line) -> Seen:
        assert line.seen is not None
        seen = line.seen()
        kept = line.pictured and seen.of == "options"
        return replace(seen, features=seen.features[self._kept]) if kept else seen

    def _probe(self, line: _Line, right: Array, learned: tuple[float, ...] | None = None) -> Probe:
        chance = 1 / self._asked[line.pictured].sizes
        return Probe(
            task=self._name,
            sees=line.sees,
            family=line.family,
            asked=len(right),
            right=float(right.sum()),
            chance=float(chance.mean()),
            deviation=power.deviation(right, chance, self._groups),
            judged=line.judged,
            why=line.why,
            learned=learned,
        )


def _asked(cases: Sequence[Case], groups: Sequence[str], struck: Sequence[NDArray[np.bool_]]) -> Asked:
    """What is to be picked, of the options that are not struck out."""
    kept = ~np.concatenate(struck)
    truth = [np.arange(c.count) == c.row["answer"] for c in cases]
    return Asked(
        owner=np.repeat(np.arange(len(cases)), [c.count for c in cases])[kept],
        name=np.array([name for c in cases for name in _classes(c)])[kept],
        truth=np.concatenate(truth)[kept],
        groups=groups,
    )


def _classes(case: Case) -> list[str]:
    """What options are called where questions are compared; pictures by their places, because names give them away."""
    return [str(i) for i in range(case.count)] if case.pictured else case.row["option_name"]


# ---------------------------------------------------------------- which there are


def _lines(cases: Sequence[Case]) -> Iterator[_Line]:
    """The probes for questions such as these."""
    shown = len(cases[0].seen_context)
    blind = (bool(shown), _BLIND if shown else _NOTHING)
    yield _Line("the place of the options", "options", True, _BLIND, _blind(features.positions, cases))
    yield _Line("the text", "text", True, _BLIND, _blind(features.texts, cases))
    yield _Line("the options", "options", *blind, _blind(features.options, cases))
    if cases[0].pictured:
        yield _Line("the options' colours", "options", *blind, _blind(features.colours, cases))
        if state.known(cases):
            yield _Line("the options' objects", "options", *blind, _forest(state.of_options, cases, ()))
        fewer = _fewer(cases, (shown - 1,)) if shown else False
        for name, scores in image_similarity.rules(cases).items():
            last = "last picture" in name
            judged = (fewer, _FEWER if fewer else _ENOUGH) if last else blind
            yield _Line(name, "rule", *judged, scores=scores, pictured=last)
    for views in _views(shown):
        yield from _seeing(cases, views)
    if shown:
        yield from _unasked(cases, tuple(range(shown)))


def _views(shown: int) -> Iterator[tuple[int, ...]]:
    """Each picture, and each pair of pictures unless there are no more."""
    yield from combinations(range(shown), 1)
    if shown > 2:
        yield from combinations(range(shown), 2)


def _seeing(cases: Sequence[Case], views: tuple[int, ...]) -> Iterator[_Line]:
    """The probes that see these pictures with the question and its options."""
    rival = _fewer(cases, views)
    if len(views) > 1 and not rival:
        return  # there is nothing to learn from what is meant to suffice
    family: Family = "picture" if len(views) == 1 else "pair"
    name = f"picture {views[0] + 1}" if len(views) == 1 else f"pictures {views[0] + 1} and {views[1] + 1}"
    known = state.known(cases)

    def line(what: str, seen: Look, framed: bool = False) -> _Line:
        why = _FRAMED if framed else _RIVAL if rival else _ENOUGH
        return _Line(f"{name}: {what}", family, False, why, seen, pictured=True, rival=rival and not framed)

    if len(views) == 1 or not known:  # of two pictures, objects tell more
        yield line("pixels", _pixels(cases, views))
    if not known:
        return
    if cases[0].pictured:
        yield line("objects", _forest(state.of_options, cases, views), rival and state.framed(cases))
        return
    yield line("objects", _forest(state.of_questions, cases, views, "questions"))
    if np.mean([state.spoken_of(c)[c.row["answer"]] is not None for c in cases]) > 0.5:
        yield line("what the options speak of", _forest(state.of_things, cases, views))


def _unasked(cases: Sequence[Case], views: tuple[int, ...]) -> Iterator[_Line]:
    """All pictures with the options, without the question: told, because the question may be what decides."""
    if len({c.row["text"] for c in cases}) > 1:
        seen = _pixels(cases, views)
        yield _Line("all pictures, not the question", "pictures", False, _UNASKED, seen, pictured=True)


def _blind(see: See, cases: Sequence[Case]) -> Look:
    return lambda: Seen(see(cases), "options", "linear")


def _pixels(cases: Sequence[Case], views: tuple[int, ...]) -> Look:
    return lambda: Seen(features.pixels(cases, views), "options" if cases[0].pictured else "questions", "forest")


def _forest(see: SeeViews, cases: Sequence[Case], views: tuple[int, ...], of: Of = "options") -> Look:
    return lambda: Seen(see(cases, views), of, "forest", ranked=not views)


def _fewer(cases: Sequence[Case], views: Sequence[int]) -> bool:
    """Whether it takes more moments to see the answer than these pictures are of, and more are shown."""
    first = cases[0]
    return len({first.row["context_time"][view] for view in views}) < min(_needed(cases), first.moments)


def _needed(cases: Sequence[Case]) -> int:
    """How many moments it takes to see the answer."""
    if cases[0].row["answer_standing"]:
        return 1
    return max(case.row.get("answer_moments") or 2 for case in cases)


def _alike(cases: Sequence[Case]) -> list[Case]:
    """The cases of the commonest form: as many pictures, and options of one kind."""
    forms = [(c.pictured, c.open, len(c.seen_context)) for c in cases]
    common = max(forms, key=forms.count, default=None)
    return [c for c, form in zip(cases, forms, strict=True) if form == common]


def _groups(unit: Unit, cases: Sequence[Case]) -> list[str]:
    """The control group of each case, which share all draws; some of them to fit to and some to judge by would mislead.

    A design that is made again a few times has few such groups. Then they are those that differ in nothing but the
    factor on which the answer hangs: a shortcut can be found so, but that there is none cannot be told.
    """
    if unit.draws >= LEAST_GROUPS:
        return [str(c.row["block"]) for c in cases]
    names = list(cases[0].varied("factor")) if not cases[0].pictured else []
    decides = max(names, key=lambda n: independence(answers_by(unit.once, n))[0], default="")
    return ["/".join(f"{n}={v}" for n, v in c.varied("factor").items() if n != decides) or c.row["id"] for c in cases]


# ---------------------------------------------------------------- what they say


def weighed(made: Sequence[Probe]) -> list[Probe]:
    """The probes with their intervals, and with the smallest shortcut that each could have found.

    All judged probes of a task are one family of tests, which raises one false alarm in twenty sound tasks.
    """
    families: dict[str, list[Probe]] = {}
    for probe in made:
        if probe.judged and probe.deviation:
            families.setdefault(task_of(probe.task), []).append(probe)
    beyond = {
        (probe.task, probe.sees): more
        for family in families.values()
        for probe, more in zip(family, power.thresholds([_reach(p) for p in family]), strict=True)
    }
    return [_weighed(probe, beyond.get((probe.task, probe.sees))) for probe in made]


def _reach(probe: Probe) -> power.Reach:
    return power.Reach(probe.chance, probe.deviation, probe.learned)


def _weighed(probe: Probe, beyond: float | None) -> Probe:
    low, high = clopper_pearson(probe.right, probe.asked, 0.95)
    if beyond is None:  # it is not judged, or a single option is left: nothing to overlook
        return replace(probe, low=low, high=high, least=1.0 - probe.judged)
    luck = probe.accuracy - probe.chance <= beyond * probe.deviation
    return replace(probe, low=low, high=high, least=power.smallest(_reach(probe), beyond), luck=luck)


def verdict(probe: Probe) -> Literal["fails", "unclear", "told", "holds"]:
    """What a judged probe says of its task."""
    if not probe.judged:
        return "told"
    slack = SLACK_SEEN if probe.family in ("picture", "pair") else SLACK
    if not probe.luck and probe.accuracy > probe.chance + slack:
        return "fails"
    return "unclear" if probe.least > ROOM else "holds"


def judge(probe: Probe) -> Finding:
    """What a probe says about its task, in words."""
    result = f"from {probe.sees} alone, {probe.accuracy:.0%} of {probe.asked:,} answered (chance {probe.chance:.0%})"
    outcome = verdict(probe)
    if outcome in ("told", "fails"):
        return Finding("shortcut", probe.task, outcome, f"{result}; {probe.why}")
    least = f"a shortcut of {100 * probe.least:.0f} points" if probe.least < 1 else "no shortcut that was tried"
    what = f"{result}; {least} would have been found"
    return Finding(
        "shortcut", probe.task, outcome, f"{what}; too few questions to tell" if outcome == "unclear" else what
    )
