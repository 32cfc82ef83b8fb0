"""Shortcut probes: tests whether questions can be answered from less information than they require.

A probe that sees no context picture must stay at chance. So must one that sees fewer moments than the answer requires:
one for a change, two for the course of a motion. Of the many probes that see one or two pictures, the best is judged
(`wmspec.dataset.audit.probe_selection`). Probes that see more are reported without judgement.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Literal

import numpy as np

from wmspec.dataset.audit import combined, features, given, image_similarity, power, state
from wmspec.dataset.audit.balance import answers_by
from wmspec.dataset.audit.cases import Case, Unit, task_of
from wmspec.dataset.audit.classify import Array, ProbeFeatures
from wmspec.dataset.audit.model import Finding, Probe
from wmspec.dataset.audit.probed import Family, Look, ProbedQuestions, ProbeSpec
from wmspec.dataset.audit.statistics import clopper_pearson, independence

#: Tolerated accuracy above chance: without pictures, of a known factor with a rule, and with some pictures.
SLACK, COMBINED_SLACK, PICTURE_SLACK = 0.05, 0.08, 0.12
#: A probe is inconclusive if it could miss a larger shortcut than this.
MAX_MISSED_SHORTCUT = 0.3
#: Minimum number of questions, and of groups, for fitting.
MIN_QUESTIONS, MIN_GROUPS = 20, 5
#: Probes of pairs see at most this many of a question's pictures, at even distances.
MAX_PAIRED_PICTURES = 8

Of = Literal["options", "questions"]
See = Callable[[Sequence[Case]], Array]
SeeViews = Callable[[Sequence[Case], Sequence[int]], Array]

#: Names of the selected probes.
_BEST = {"picture": "single picture", "pair": "pair of pictures"}

_SLACKS: dict[str, float] = {"picture": PICTURE_SLACK, "pair": PICTURE_SLACK, "combination": COMBINED_SLACK}

_BLIND = "it sees none of the pictures"
_FEWER = "the answer requires more moments than it sees"
_ENOUGH = "it sees as many moments as the answer requires"
_NOTHING = "the question has no context pictures, so the options are its only input"
_FRAMED = "options that differ in the action alone share their initial state, so one picture shows the displacement"
_RIVAL = "only the best of these probes is judged"
_UNASKED = "without the question, the object in question is unknown"


def probes(unit: Unit, units: Sequence[Unit] = ()) -> list[Probe]:
    """Return the results of all applicable probes; empty if questions are too few or have no options.

    `units` has the companion questions of the task: a prediction requires as many moments as these require together.
    """
    cases = _most_frequent_form(unit.sampled)
    if moments := given.required_moments(units, unit):
        cases = [case.requiring(moments) for case in cases]
    if len(cases) < MIN_QUESTIONS or cases[0].open:
        return []
    groups = _groups(unit, cases)
    if len(set(groups)) < MIN_GROUPS:
        return []
    lines = list(_probe_specs(cases))
    none = [np.zeros(case.count, dtype=bool) for case in cases]
    eliminated = (none, state.eliminated_options(cases))  # without pictures, and by any picture
    every, left = (ProbedQuestions.of(unit.name, cases, groups, struck) for struck in eliminated)
    made = [(left if line.pictured else every).probe(line) for line in lines if not line.competes]
    for family in dict.fromkeys(line.family for line in lines if line.competes):
        rivals = [line for line in lines if line.competes and line.family == family]
        made += left.rivals(f"the best {_BEST[family]} ({{}})", _FEWER, rivals)
    return made + combined.probes(unit, cases, groups, max(case.required_moments for case in cases))


# ---------------------------------------------------------------- catalogue


def _probe_specs(cases: Sequence[Case]) -> Iterator[ProbeSpec]:
    """Yield the applicable probes."""
    shown = len(cases[0].context_thumbnails)
    blind = (bool(shown), _BLIND if shown else _NOTHING)
    yield ProbeSpec("the place of the options", "options", True, _BLIND, _blind(features.positions, cases))
    yield ProbeSpec("the text", "text", True, _BLIND, _blind(features.texts, cases))
    yield ProbeSpec("the options", "options", *blind, _blind(features.options, cases))
    if cases[0].has_picture_options:
        yield ProbeSpec("the options' colours", "options", *blind, _blind(features.colours, cases))
        if state.has_object_states(cases):
            yield ProbeSpec("the options' objects", "options", *blind, _forest(state.option_states, cases, ()))
        fewer = _sees_too_few_moments(cases, (shown - 1,)) if shown else False
        for name, scores in image_similarity.rules(cases).items():
            last = "last picture" in name
            judged = (fewer, _FEWER if fewer else _ENOUGH) if last else blind
            yield ProbeSpec(name, "rule", *judged, scores=scores, pictured=last)
    for views in view_sets(shown):
        yield from _picture_probes(cases, views)
    if shown and len({c.row["text"] for c in cases}) > 1:  # not judged, since the question may decide the answer
        seen = _pixels(cases, tuple(range(shown)))
        yield ProbeSpec("all pictures without the question", "pictures", False, _UNASKED, seen, pictured=True)


def view_sets(shown: int) -> Iterator[tuple[int, ...]]:
    """Yield each picture, and each pair of at most `MAX_PAIRED_PICTURES` pictures, unless a pair is all of them.

    Neighbours in a long series are similar, and the time of the audit grows with the number of pairs.
    """
    yield from combinations(range(shown), 1)
    if shown > 2:
        places = np.linspace(0, shown - 1, min(shown, MAX_PAIRED_PICTURES)).round().astype(int).tolist()
        yield from combinations(places, 2)


def _picture_probes(cases: Sequence[Case], views: tuple[int, ...]) -> Iterator[ProbeSpec]:
    """Yield the probes that see these pictures with the question and its options."""
    competes = _sees_too_few_moments(cases, views)
    if len(views) > 1 and not competes:
        return  # these pictures are meant to suffice
    family: Family = "picture" if len(views) == 1 else "pair"
    name = f"picture {views[0] + 1}" if len(views) == 1 else f"pictures {views[0] + 1} and {views[1] + 1}"
    known = state.has_object_states(cases)

    def line(what: str, seen: Look, framed: bool = False) -> ProbeSpec:
        why = _FRAMED if framed else _RIVAL if competes else _ENOUGH
        return ProbeSpec(f"{name}: {what}", family, False, why, seen, pictured=True, competes=competes and not framed)

    if len(views) == 1 or not known:  # for two pictures, object states are stronger features
        yield line("pixels", _pixels(cases, views))
    if not known:
        return
    if cases[0].has_picture_options:
        yield line(
            "objects", _forest(state.option_states, cases, views), competes and state.reveals_initial_state(cases)
        )
        return
    yield line("objects", _forest(state.question_states, cases, views, "questions"))
    if np.mean([state.named_objects(c)[c.row["answer"]] is not None for c in cases]) > 0.5:
        yield line("objects named by the options", _forest(state.named_object_states, cases, views))


def _blind(see: See, cases: Sequence[Case]) -> Look:
    return lambda: ProbeFeatures(see(cases), "options", "linear")


def _pixels(cases: Sequence[Case], views: tuple[int, ...]) -> Look:
    return lambda: ProbeFeatures(
        features.pixels(cases, views), "options" if cases[0].has_picture_options else "questions", "forest"
    )


def _forest(see: SeeViews, cases: Sequence[Case], views: tuple[int, ...], of: Of = "options") -> Look:
    return lambda: ProbeFeatures(see(cases, views), of, "forest", ranked=not views)


def _sees_too_few_moments(cases: Sequence[Case], views: Sequence[int]) -> bool:
    """Whether these pictures cover fewer moments than the answer requires, while more are shown."""
    first, moments = cases[0], max(case.required_moments for case in cases)
    return len({first.row["context_time"][view] for view in views}) < min(moments, first.moments)


def _most_frequent_form(cases: Sequence[Case]) -> list[Case]:
    """Return the cases of the most frequent form: number of pictures and type of options."""
    forms = [(c.has_picture_options, c.open, len(c.context_thumbnails)) for c in cases]
    common = max(forms, key=forms.count, default=None)
    return [c for c, form in zip(cases, forms, strict=True) if form == common]


def _groups(unit: Unit, cases: Sequence[Case]) -> list[str]:
    """Return the control group of each case. Groups share draws, so they must not be split between training and test.

    A design with few repetitions has few groups. Then the groups are the cases that differ only in the factor that
    determines the answer. These can reveal a shortcut but not prove its absence.
    """
    if unit.draws >= MIN_GROUPS:
        return [str(c.row["block"]) for c in cases]
    names = list(cases[0].varied("factor")) if not cases[0].has_picture_options else []
    decides = max(names, key=lambda n: independence(answers_by(unit.per_instance, n))[0], default="")
    return ["/".join(f"{n}={v}" for n, v in c.varied("factor").items() if n != decides) or c.row["id"] for c in cases]


# ---------------------------------------------------------------- verdicts


def with_intervals(made: Sequence[Probe]) -> list[Probe]:
    """Return the probes with their intervals and smallest detectable shortcuts.

    All judged probes of a task form one family of tests, with one false alarm in twenty sound tasks.
    """
    families: dict[str, list[Probe]] = {}
    for probe in made:
        if probe.judged and probe.deviation:
            families.setdefault(task_of(probe.task), []).append(probe)
    beyond = {
        (probe.task, probe.sees): more
        for family in families.values()
        for probe, more in zip(family, power.thresholds(family), strict=True)
    }
    return [_with_interval(probe, beyond.get((probe.task, probe.sees))) for probe in made]


def _with_interval(probe: Probe, beyond: float | None) -> Probe:
    low, high = clopper_pearson(probe.right, probe.questions, 0.95)
    if beyond is None:  # not judged, or a single option remains
        return replace(probe, low=low, high=high, least=1.0 - probe.judged)
    luck = probe.accuracy - probe.chance <= beyond * probe.deviation
    return replace(probe, low=low, high=high, least=power.smallest_detectable(probe, beyond), luck=luck)


def verdict(probe: Probe) -> Literal["fails", "unclear", "reported", "holds"]:
    """Return the verdict of a probe."""
    if not probe.judged:
        return "reported"
    slack = _SLACKS.get(probe.family, SLACK)
    if not probe.luck and probe.accuracy > probe.chance + slack:
        return "fails"
    return "unclear" if probe.least > MAX_MISSED_SHORTCUT else "holds"


def judge(probe: Probe) -> Finding:
    """Return the finding of a probe."""
    result = f"from {probe.sees} alone, {probe.accuracy:.0%} of {probe.questions:,} right (chance {probe.chance:.0%})"
    outcome = verdict(probe)
    if outcome in ("reported", "fails"):
        return Finding("shortcut", probe.task, outcome, f"{result}; {probe.why}")
    least = f"a shortcut of {100 * probe.least:.0f} points" if probe.least < 1 else "no tested shortcut"
    what = f"{result}; {least} would have been detected"
    return Finding(
        "shortcut", probe.task, outcome, f"{what}; too few questions for a conclusion" if outcome == "unclear" else what
    )
