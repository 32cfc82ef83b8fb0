"""Checks of actions: valid targets, finite numbers, order in time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import ArrayLike

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.model import (
    Action,
    Follow,
    Force,
    Glide,
    Grip,
    Impulse,
    Joint,
    Launch,
    Paint,
    PassThrough,
    Release,
    Scene,
    Steer,
    Teleport,
    Vanish,
)
from wmspec.sim.scene.physics.paths import misplaced_paths, overlaps

_MOVED, _FREE = ("kinematic",), ("dynamic",)
MOTIONS = {
    Launch: _FREE,
    Glide: _MOVED,
    Follow: _MOVED,
    Teleport: (*_FREE, *_MOVED),
    Impulse: _FREE,
    Force: _FREE,
    Release: _FREE,
    Grip: _FREE,
    Paint: (*_FREE, *_MOVED, "static"),
    Vanish: (*_FREE, *_MOVED),
    PassThrough: (*_FREE, *_MOVED),
}
"""The kinds of bodies that each action accepts."""


def problems(action: Action, motions: Mapping[str, str], joints: Mapping[str, Joint]) -> Iterator[Diagnostic]:
    """Yield the errors of one action, given the `motions` of bodies and the `joints` by name."""
    if isinstance(action, Steer):
        if action.joint not in joints or joints[action.joint].drive is None:
            yield Diagnostic(f"there is no joint '{action.joint}' with a drive", help="give the joint one")
    else:
        needed = MOTIONS[type(action)]
        if action.body not in motions:
            yield Diagnostic(f"there is no body '{action.body}'", help=f"there are {', '.join(motions)}")
        elif motions[action.body] not in needed:
            motion, expected = motions[action.body], " or ".join(needed)
            yield Diagnostic(f"it moves '{action.body}', which is {motion}, expected a {expected} body")
    if isinstance(action, Grip) and motions.get(action.hand) != "kinematic":
        yield Diagnostic(f"there is no kinematic body '{action.hand}' to grip with")
    if isinstance(action, PassThrough) and (action.through not in motions or action.through == action.body):
        yield Diagnostic(f"there is no other body '{action.through}' to go through")
    if not (action.start >= 0 and all(np.isfinite(v).all() for v in _numbers(action))):
        yield Diagnostic("its start is negative or a number is not finite")
    elif isinstance(action, Follow):
        yield from _way(action)
    elif isinstance(action, Glide | Force | Grip | PassThrough) and action.stop < action.start:
        yield Diagnostic(f"it stops at {action.stop} s, before it starts at {action.start} s")


def _way(action: Follow) -> Iterator[Diagnostic]:
    n = len(action.times)
    if n < 2 or action.points.shape != (n, 3) or (action.orientations is not None and len(action.orientations) != n):
        yield Diagnostic(f"it has {n} times, expected at least 2, and the same number of points and orientations")
    elif action.times[0] != 0 or not (np.diff(action.times) > 0).all():
        yield Diagnostic(f"its times are {action.times.tolist()}, expected increasing times from 0")


def _numbers(action: Action) -> list[ArrayLike]:
    """Return all numbers of an action, which must be finite."""
    return [value for value in vars(action).values() if not isinstance(value, str | None)]


def sequence(scene: Scene) -> Iterator[Diagnostic]:
    """Yield conflicts between the actions of one body."""
    for first, second in overlaps(scene.actions, scene.bodies):
        yield Diagnostic(
            f"it starts while {first.name} still moves '{second.body}'",
            PrimPlace(f"action {second.name}"),
            "end the first one before",
        )
    releases = {action.body: action for action in scene.actions if isinstance(action, Release)}
    for action in scene.actions:
        if isinstance(action, Launch | Impulse | Force | Vanish | Teleport) and action.body in releases:
            release = releases[action.body]
            if action.start < release.start:
                yield Diagnostic(
                    f"'{action.body}' is held until {release.start} s",
                    PrimPlace(f"action {action.name}"),
                    "start at that time or later",
                )
    for follow, here in misplaced_paths(scene):
        yield (
            Diagnostic(
                f"its path starts at {follow.points[0]} m, but '{follow.body}' is at {here} m or rotated otherwise",
                PrimPlace(f"action {follow.name}"),
                "start the path there or teleport the body before",
            )
        )
