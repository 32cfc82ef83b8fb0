"""What the option pictures of a question vary, and where its levels are given: in the text or by a companion question.

In a closed set of pictures each option has one level of each varied factor. A level is given in the text if the text
differs with it, and by a companion question of the task if the answer to that differs with it.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.model import Finding

#: A level is given if this share of the pairs of instances that differ in it alone differ in the text or the answer.
MIN_SHARE = 0.95

_CHANGE = re.compile(r"(action|state) ([^\s:]+): (.*) -> (.*)")

Kind = Literal["action", "state"]


@dataclass(frozen=True)
class ClosedSet:
    """The closed set of option pictures of a question: each option has a level (in words) of every varied factor.

    `kinds` is the kind of each factor, `levels` the level of each option by factor.
    """

    kinds: dict[str, Kind]
    levels: dict[str, tuple[str, ...]]

    def left(self, known: str, answer: int) -> tuple[bool, ...]:
        """Return the options that are left if the level of a factor is known: those with the level of the truth."""
        return tuple(level == self.levels[known][answer] for level in self.levels[known])

    def others(self, known: str) -> list[str]:
        """Return the varied factors but one."""
        return [name for name in self.levels if name != known]


def closed_set(case: Case) -> ClosedSet | None:
    """Return the closed set of a question; None if its options are no such set."""
    if not case.has_picture_options:
        return None
    parsed = [_parse(change) for change in case.row["option_change"] or ()]
    changes = [change for i, change in enumerate(parsed) if i != case.row["answer"]]
    if not all(changes):
        return None
    kinds = {name: kind for change in changes if change for name, (kind, _, _) in change.items()}
    truth = {name: before for change in changes if change for name, (_, before, _) in change.items()}
    levels = {
        name: tuple(change[name][2] if change and name in change else truth[name] for change in parsed)
        for name in sorted(kinds)
    }
    return ClosedSet({name: kinds[name] for name in levels}, levels)


def _parse(change: str | None) -> dict[str, tuple[Kind, str, str]] | None:
    """Return what an option changes: by factor, kind, level before and after. None if it changes something else."""
    made: dict[str, tuple[Kind, str, str]] = {}
    for part in change.split("; ") if change else ():
        match = _CHANGE.fullmatch(part)
        if not match:
            return None
        made[match[2]] = ("action" if match[1] == "action" else "state", match[3], match[4])
    return made


def varied_factors(cases: Sequence[Case]) -> dict[str, Kind]:
    """Return the factors that the closed sets vary, with their kind; empty unless all questions vary the same."""
    sets = [closed_set(case) for case in cases]
    first = sets[0] if sets else None
    return dict(first.kinds) if first and all(one and one.kinds == first.kinds for one in sets) else {}


def given_in_words(unit: Unit, factor: str) -> bool:
    """Whether the text of the question gives the level of a factor."""
    return _differs(unit.per_instance, {case.row["index"]: case.row["text"] for case in unit.per_instance}, factor)


def given_by(units: Sequence[Unit], unit: Unit, factor: str) -> list[str]:
    """Return the names of the companion questions of a task whose answers give the level of a factor."""
    return [other.name for other in units if other is not unit and _differs(unit.per_instance, _answers(other), factor)]


def required_moments(units: Sequence[Unit], unit: Unit) -> int | None:
    """Return how many moments show the levels that the options of a question vary.

    A level in the text requires one, and a level that a companion question gives as many as that question. None if some
    level is not given, or if the options are no closed set.
    """
    required = [_moments_of_level(units, unit, name) for name in varied_factors(unit.per_instance)]
    return None if None in required else max(filter(None, required), default=None)


def _moments_of_level(units: Sequence[Unit], unit: Unit, factor: str) -> int | None:
    if given_in_words(unit, factor):
        return 1
    named = given_by(units, unit, factor)
    companions = (other for other in units if other.name in named)
    return min((max(case.required_moments for case in other.cases) for other in companions), default=None)


def companion_finding(units: Sequence[Unit], unit: Unit) -> Finding | None:
    """Return whether the words or the companion questions give all that the options vary; None without companions.

    The filter of the report keeps questions whose companions are answered correctly. It means nothing if these concern
    something else.
    """
    varied = varied_factors(unit.per_instance)
    if not varied or len(units) < 2:
        return None
    words = [name for name in varied if given_in_words(unit, name)]
    companions = {name: given_by(units, unit, name) for name in varied if name not in words}
    where = [f"`{name}` in the text" for name in words] + [
        f"`{name}` by {' and '.join(questions)}" for name, questions in companions.items() if questions
    ]
    absent = [f"`{name}`" for name, questions in companions.items() if not questions]
    known = f"the options vary {' and '.join(f'`{name}`' for name in varied)}"
    if absent:
        what = f"{known}, and no companion question concerns {' and '.join(absent)}"
        return Finding("companions", unit.name, "fails", what)
    return Finding("companions", unit.name, "holds", f"{known}; given: {', '.join(where)}")


def _answers(unit: Unit) -> dict[int, object]:
    """Return the true answer of each instance in words; the value of open questions."""
    return {
        case.row["index"]: case.row["answer_value"] if case.open else case.row["option_name"][case.row["answer"]]
        for case in unit.per_instance
        if not case.has_picture_options
    }


def _differs(cases: Sequence[Case], values: Mapping[int, object], factor: str) -> bool:
    """Whether a value differs between instances of a group that differ in the factor alone."""
    alike: dict[tuple[object, ...], list[tuple[object, object]]] = defaultdict(list)
    for case in cases:
        levels = case.varied("factor")
        if factor not in levels or case.row["index"] not in values:
            continue
        rest = tuple(str(levels[name]) for name in case.row["crossed"] if name != factor)
        alike[case.row["block"], *rest].append((levels[factor], values[case.row["index"]]))
    pairs = [a[1] != b[1] for members in alike.values() for a, b in combinations(members, 2) if str(a[0]) != str(b[0])]
    return bool(pairs) and sum(pairs) >= MIN_SHARE * len(pairs)
