"""Gate: pictures must show what a question is about, large enough, within the frame, unoccluded, with contrast."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.runtime.questions import visibility
from wmspec.runtime.questions.declared_visibility import DeclaredVisibility
from wmspec.runtime.questions.model import Reject
from wmspec.runtime.questions.observed import Observed
from wmspec.runtime.questions.patch import patch
from wmspec.runtime.questions.views import View
from wmspec.sim.scene.render.appearance import vanished_bodies

#: Smallest visible share of the picture: 6 x 6 of 256 x 256 pixels.
MIN_VISIBLE_SHARE = 36 / 256**2
#: Smallest share of a movable body inside the frame, and largest occluded share of that.
MIN_INSIDE, MAX_HIDDEN = 0.5, 0.7
#: Every body must be visible in every picture.
_EVERYWHERE = DeclaredVisibility()
#: Smallest colour difference (CIEDE2000) to the surround: visible at a glance.
MIN_CONTRAST = 5.0


def connected_sets(values: Evaluator) -> list[frozenset[str]]:
    """Return the sets whose members are joined, such as ropes, which count as one object."""
    sets = {thing.name: thing.set for thing in values.spec.things if thing.kind == "object" and thing.set}
    tied = set[str]()
    for joint in values.spec.things:
        if joint.kind == "joint" and values.has(joint.name, "to") and values.is_present(joint.name):
            ends = values.ends(joint.name)
            tied |= {sets[ends[0]]} if ends[0] in sets and sets[ends[0]] == sets.get(ends[1]) else set()
    return [frozenset(name for name, of in sets.items() if of == chain) for chain in sorted(tied)]


def require_visible(
    observed: Observed,
    names: Iterable[str],
    together: Iterable[frozenset[str]] = (),
    declared: DeclaredVisibility = _EVERYWHERE,
) -> None:
    """Raise Reject unless at every observed moment one camera shows each body well, as far as `declared` requires it.

    Sets in `together` need only as much visibility as one body. If only attached cameras show a body, once is enough.
    The body that carries such a camera need not be visible. A body that has vanished is not visible.
    """
    riding = {c.name: c.body for c in observed.scene.cameras if c.body is not None}
    fixed = [view for view in observed.views if view[0] not in riding]
    for group in _there(observed, names, together):
        views = [view for view in observed.views if declared.requires(group, view[1])]
        if fixed:
            for time in sorted({time for _, time in fixed}.intersection(time for _, time in views)):
                _seen_once(observed, group, [view for view in views if view[1] == time])
        elif views and group[0] not in riding.values():
            _seen_once(observed, group, views)


def require_visible_in(
    option: str,
    observed: Observed,
    names: Iterable[str],
    together: Iterable[frozenset[str]] = (),
    declared: DeclaredVisibility = _EVERYWHERE,
) -> None:
    """Raise Reject unless the picture of an option shows each body well, as far as `declared` requires it.

    Pictures of attached cameras need not.
    """
    (view,) = observed.views
    if any(c.name == view[0] and c.body is not None for c in observed.scene.cameras):
        return
    for group in _there(observed, names, together):
        if not declared.requires(group, view[1]):
            continue
        if fault := _unseen(observed, group, view):
            raise Reject("unseen", f"{group[0]} in option {option}: {fault}")


def _there(observed: Observed, names: Iterable[str], together: Iterable[frozenset[str]]) -> list[tuple[str, ...]]:
    """Return the present bodies, alone or with their set."""
    requested, whole = set(names), {name: group for group in together for name in group}
    there = [body.name for body in observed.scene.bodies]
    groups = (tuple(n for n in there if n in whole.get(name, {name})) for name in there if name in requested)
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
    """Return why a body or set is not visible in a view; '' if it is visible."""
    if vanished_bodies(observed.scene, view[1]).issuperset(group):
        return "it has vanished"
    if len(group) == 1:
        return invisibility_reason(observed, group[0], view)
    frame = observed.picture(*view)
    pixels = sum(patch(frame, observed.index(name)).pixels for name in group)
    size = frame.ids.size
    return f"{pixels} of {size} pixels of all {len(group)}" if pixels < MIN_VISIBLE_SHARE * size else ""


def invisibility_reason(observed: Observed, name: str, view: View) -> str:
    """Return why a body is not visible in a view; '' if it is."""
    index = observed.index(name)
    frame = observed.picture(*view)
    pixels = patch(frame, index).pixels
    if pixels < MIN_VISIBLE_SHARE * frame.ids.size:
        return f"{pixels} of {frame.ids.size} pixels{_hindrance(observed, index, view)}"
    can_move = observed.scene.bodies[index].motion != "static"
    if can_move and visibility.hidden_share_bound(observed, index, view) > MAX_HIDDEN:
        outline = visibility.outline(observed, index, view)
        if outline.inside < MIN_INSIDE * outline.all:
            return f"{1 - outline.inside / outline.all:.0%} of it is outside the frame"
        if pixels < (1 - MAX_HIDDEN) * outline.inside:
            return f"{1 - pixels / outline.inside:.0%} of it is hidden"
    contrast = visibility.surround_contrast(frame, index)
    if contrast < MIN_CONTRAST:
        return f"its contrast is low: its colour differs by {contrast:.1f}, and {MIN_CONTRAST:g} can be seen"
    return ""


def _hindrance(observed: Observed, index: int, view: View) -> str:
    """Return why a picture shows hardly anything of a body: the frame, or the body in front of most of it."""
    frame = observed.picture(*view)
    inside = visibility.outline(observed, index, view).inside
    if not inside:
        return ": it is outside the frame"
    if inside < MIN_VISIBLE_SHARE * frame.ids.size:
        return ": too little of it is inside the frame, or it is too small"
    hiding = visibility.body_in_front(observed, index, view)
    return f": it is hidden behind {hiding}" if hiding else ""
