"""Trying a spec out: the scenes of a sample of instances and counterfactuals are built, nothing is executed."""

from __future__ import annotations

from dataclasses import replace

from wmspec.compile.design.depend import Dependencies
from wmspec.compile.design.design import Design
from wmspec.compile.layout.values import Values
from wmspec.compile.lint import (
    action_rules,
    change_rules,
    design_rules,
    giveaway_rules,
    hidden_rules,
    option_rules,
    plausible_rules,
    regime_rules,
    scene_rules,
    task_rules,
)
from wmspec.compile.lint.change_rules import Changed
from wmspec.compile.lint.option_rules import Tried, compared
from wmspec.compile.lint.rule import Linter
from wmspec.compile.lint.scene_rules import Scene
from wmspec.compile.lint.task_rules import Task
from wmspec.compile.stage import episode
from wmspec.core.diagnostics import Report
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.parse.load import pointed

#: How many instances are tried. Of so many things all are built, a third of them with every counterfactual; else fewer.
TRIED, THINGS = 12, 100
#: However many things there are, so many are built, half of them with every counterfactual.
FEWEST = 4
#: What a robot does takes as long to plan as so many things to build.
PLANNED = 40


def dry_run(spec: TaskSpec, report: Report) -> Design | None:
    """Report what goes wrong with the values of a spec; returns its design, if it has one."""
    linter, depend, design = Linter(), Dependencies(spec), None
    with linter.going_on():
        linter.check(Task(spec, depend), (*task_rules.RULES, *giveaway_rules.TASK_RULES))
        design = Design(spec)
        linter.check(design, design_rules.RULES)
        instances = [design[index] for index in design.sample(TRIED)]
        tried = [Values(spec, instance.values, None, instance.key) for instance in instances]
        work = len(spec.things) + PLANNED * sum(thing.kind == "action" and bool(thing.of) for thing in spec.things)
        built = max(FEWEST, TRIED * THINGS // max(THINGS, work))
        for count, (values, instance) in enumerate(zip(tried[:built], instances, strict=False)):
            with linter.going_on():
                _scene(Scene(values, depend, design, instance), linter, changed=count < max(FEWEST // 2, built // 3))
        for question in spec.questions:
            with linter.going_on():
                linter.check(Tried(question, tuple(tried)), option_rules.ALWAYS)
                linter.check(compared(question, design, depend), option_rules.RULES)
    report.include(pointed(linter.report.diagnostics))
    return design


def _scene(scene: Scene, linter: Linter, *, changed: bool) -> None:
    """Lint the scene of an instance, with its counterfactuals if `changed`. Raises WmsError if it cannot be staged."""
    spec, instance = scene.values.spec, scene.instance
    stage = episode.built(scene.values)
    linter.check(scene, scene_rules.RULES)
    linter.check(scene, plausible_rules.RULES)
    linter.check(scene, action_rules.RULES)
    linter.check(scene, hidden_rules.RULES)
    linter.check(scene, regime_rules.RULES)
    linter.check(scene, giveaway_rules.SCENE_RULES)
    things = {t.name for t in spec.things}
    for question in spec.questions if changed else ():
        for change in question.alternatives(instance.factors):
            if change.change == "levels" or change.owner in things:
                with linter.going_on():
                    otherwise = replace(scene, values=Values(spec, instance.values, change, instance.key))
                    linter.check(Changed(question, change, scene, stage, otherwise), change_rules.RULES)
