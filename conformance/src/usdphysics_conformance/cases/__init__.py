"""The cases, by topic."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from functools import cache

from usdphysics_conformance.case import Case, ConformanceError


@cache
def all_cases() -> dict[str, Case]:
    """All cases by name, in the order of the score card."""
    from usdphysics_conformance.cases import impacts, joints, mechanisms, single_body

    return {case.name: case for topic in (single_body, impacts, joints, mechanisms) for case in topic.build_cases()}


def select_cases(names: Iterable[str] = ()) -> tuple[Case, ...]:
    """The cases of these names, or all if there are no names. Raises ConformanceError for an unknown name."""
    known = all_cases()
    names = tuple(dict.fromkeys(names)) or tuple(known)
    for name in names:
        if name not in known:
            close = get_close_matches(name, known, n=1)
            remedy = f"did you mean `{close[0]}`?" if close else "`usdphysics-conformance list` names all"
            raise ConformanceError(f"there is no case `{name}`; {remedy}")
    return tuple(known[name] for name in names)
