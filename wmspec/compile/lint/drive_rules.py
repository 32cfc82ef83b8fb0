"""Rules on drives that are too stiff for the step rate of engines that integrate them explicitly."""

from __future__ import annotations

from collections.abc import Iterator

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import mass, pieces, volume
from wmspec.compile.lint.regime_rules import ENGINES_REMEDY
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import LintScene
from wmspec.core.space import add, dot, inverse, rotate, scale, unit
from wmspec.lang.check.ir.ir import Entity
from wmspec.sim.scene.regime_thresholds import COARSEST_STEP_RATE, MAX_STEP_MULTIPLIER, MAX_STEP_RESPONSE

#: Highest step rate (Hz) of the coarsest engine.
_RATE = MAX_STEP_MULTIPLIER * COARSEST_STEP_RATE


@rule("WMS608")
def stiff_drive(scene: LintScene) -> Iterator[Breach]:
    """Find drives of the last object of a chain that oscillate or decay within a few steps.

    The inertia of an object whose moments are given, and of one that carries others, is not known here.
    """
    values = scene.values
    joints = [t for t in values.spec.things if t.kind == "joint" and values.is_present(t.name)]
    ends = [end for joint in joints for end in values.ends(joint.name)]
    for joint in joints:
        if joint.of or joint.model not in ("hinge", "slider"):
            continue
        moved = values.reference(joint.name, "of")
        if ends.count(moved) > 1 or values.flag(moved, "fixed") or values.has(moved, "moments"):
            continue
        load = mass(values, moved) if joint.model == "slider" else _moment(values, joint, moved)
        load += values.number(joint.name, "armature") if values.has(joint.name, "armature") else 0.0
        for word, power in (("stiffness", 2), ("damping", 1)):
            most = MAX_STEP_RESPONSE * _RATE**power * load
            if values.number(joint.name, word) > most:
                what = f"the {word} of `{joint.name}` is too high for its load `{moved}` {scene.where}"
                why = "engines that integrate drives explicitly refuse it"
                remedy = f"keep it below {float(f'{most:.1g}'):g}, make `{moved}` heavier, or {ENGINES_REMEDY}"
                yield Breach(f"{what}; {why}", values.source_location(joint.name, word), remedy, about=joint.name)


def _moment(values: Evaluator, joint: Entity, moved: str) -> float:
    """Return the moment of inertia (kg m²) of an object about the axis of its hinge (Huygens and Steiner)."""
    axis, pose = unit(values.vector(joint.name, "axis")), values.pose(moved)
    density, moment = mass(values, moved) / volume(values, moved), 0.0
    for piece in pieces(values, moved):
        place = pose.compose(piece.pose)
        along = rotate(inverse(place.orientation), axis)
        own = sum(a * dot(row, along) for a, row in zip(along, piece.solid.tensor, strict=True))
        arm = add(place.apply(piece.solid.center), scale(-1.0, values.vector(joint.name, "at")))
        moment += density * piece.solid.volume * (own + dot(arm, arm) - dot(arm, axis) ** 2)
    return moment


RULES = (stiff_drive,)
