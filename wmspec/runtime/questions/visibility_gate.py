"""Whether pictures show what a question is about: large enough, within the frame, not hidden, standing out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from wmspec.compile.layout.values import Values
from wmspec.runtime.questions import visibility
from wmspec.runtime.questions.model import Reject
from wmspec.runtime.questions.observed import Observed
from wmspec.runtime.questions.patch import patch
from wmspec.runtime.questions.views import View
from wmspec.sim.scene.render.appearance import vanished

#: A body that covers less of a picture than this cannot be seen in it. (A 6 x 6 patch of 256 x 256 pixels.)
LEAST_VISIBLE = 36 / 256**2
#: Of a body that can move, at least this share must be within the frame, and of that no more be hidden by others.
LEAST_INSIDE, MOST_HIDDEN = 0.5, 0.7
#: A body's colour must differ by this (CIEDE2000) from what is around it: what is seen at a glance.
LEAST_CONTRAST = 5.0


def chains(values: Values) -> list[frozenset[str]]:
    """The sets whose members joints tie to one another: ropes, each of which is seen as one thing."""
    sets = {thing.name: thing.set for thing in values.spec.things if thing.kind == "object" and thing.set}
    tied = set[str]()
    for joint in values.spec.things:
        if joint.kind == "joint" and values.has(joint.name, "to") and values.there(joint.name):
            ends = values.ends(joint.name)
            tied |= {sets[ends[0]]} if ends[0] in sets and sets[ends[0]] == sets.get(ends[1]) else set()
    return [frozenset(name for name, of in sets.items() if of == chain) for chain in sorted(tied)]


def shown(observed: Observed, names: Iterable[str], together: Iterable[frozenset[str]] = ()) -> None:
    """Raise Reject unless at every moment that was looked at, one of the cameras shows each of the bodies well.

    Of those that are seen `together` as one thing, so much as of one body must be seen. Cameras that ride see what they
    come by: where only they look, a body must be well seen once. What carries such a camera need not be seen.
    """
    riding = {c.name: c.body for c in observed.scene.cameras if c.body is not None}
    fixed = [view for view in observed.views if view[0] not in riding]
    moments = sorted({time for _, time in fixed})
    for group in _there(observed, names, together):
        if fixed:
            for time in moments:
                _seen_once(observed, group, [view for view in observed.views if view[1] == time])
        elif group[0] not in riding.values():
            _seen_once(observed, group, observed.views)


def shown_in(option: str, observed: Observed, names: Iterable[str], together: Iterable[frozenset[str]] = ()) -> None:
    """Raise Reject unless the one picture of an option shows each of the bodies well; a riding camera's need not."""
    (view,) = observed.views
    if any(c.name == view[0] and c.body is not None for c in observed.scene.cameras):
        return
    for group in _there(observed, names, together):
        if fault := _unseen(observed, group, view):
            raise Reject("unseen", f"{group[0]} in option {option}: {fault}")


def _there(observed: Observed, names: Iterable[str], together: Iterable[frozenset[str]]) -> list[tuple[str, ...]]:
    """The bodies that are there, each by itself or with those that it is seen together with."""
    wanted, whole = set(names), {name: group for group in together for name in group}
    there = [body.name for body in observed.scene.bodies]
    groups = (tuple(n for n in there if n in whole.get(name, {name})) for name in there if name in wanted)
    return list(dict.fromkeys(groups))


def _seen_once(observed: Observed, group: tuple[str, ...], views: Sequence[View]) -> None:
    faults = []
    for view in views:
        fault = _unseen(observed, group, view)
        if not fault:
            return
        faults.append(f"{group[0]} from {view[0]} at {view[1]:g} s: {fault}")
    raise Reject("unseen", "; ".join(faults))


def _unseen(observed: Observed, group: tuple[str, ...], view: View) -> str:
    """Why a body, or bodies that are seen as one thing, are not well seen in a view; empty if they are, or are gone."""
    if vanished(observed.scene, view[1]).issuperset(group):
        return ""
    if len(group) == 1:
        return unseen(observed, group[0], view)
    frame = observed.picture(*view)
    pixels = sum(patch(frame, observed.index(name)).pixels for name in group)
    size = frame.ids.size
    return f"{pixels} of {size} pixels of all {len(group)}" if pixels < LEAST_VISIBLE * size else ""


def unseen(observed: Observed, name: str, view: View) -> str:
    """Why a body is not well seen in a view; empty if it is."""
    index = observed.index(name)
    frame = observed.picture(*view)
    pixels = patch(frame, index).pixels
    if pixels < LEAST_VISIBLE * frame.ids.size:
        return f"{pixels} of {frame.ids.size} pixels"
    can_move = observed.scene.bodies[index].motion != "static"
    if can_move and visibility.hidden_at_most(observed, index, view) > MOST_HIDDEN:
        outline = visibility.outline(observed, index, view)
        if outline.inside < LEAST_INSIDE * outline.all:
            return f"{1 - outline.inside / outline.all:.0%} of it is outside the frame"
        if pixels < (1 - MOST_HIDDEN) * outline.inside:
            return f"{1 - pixels / outline.inside:.0%} of it is hidden"
    contrast = visibility.outstanding(frame, index)
    if contrast < LEAST_CONTRAST:
        return f"it hardly stands out: its colour differs by {contrast:.1f}, and {LEAST_CONTRAST:g} can be seen"
    return ""
