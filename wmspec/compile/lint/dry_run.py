"""Dry run: builds the scenes of sampled instances and counterfactuals without executing them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from wmspec.compile.design.depend import dependencies
from wmspec.compile.design.design import Design
from wmspec.compile.design.what_ifs import what_ifs
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.lint import (
    action_rules,
    change_rules,
    giveaway_rules,
    hidden_rules,
    option_rules,
    plausible_rules,
    regime_rules,
    scene_rules,
    task_rules,
)
from wmspec.compile.lint.change_rules import ChangedScene
from wmspec.compile.lint.option_rules import SampledQuestion, compare_options
from wmspec.compile.lint.rule import Linter
from wmspec.compile.lint.scene_rules import LintScene
from wmspec.compile.lint.task_rules import LintTask
from wmspec.compile.stage import episode
from wmspec.compile.stage.object_cache import ObjectCache
from wmspec.core.diagnostics import Report
from wmspec.lang.check.ir.ir import Counterfactual, TaskSpec
from wmspec.lang.parse.load import with_source_text

#: Maximum number of sampled instances. Up to ENTITY_BUDGET entities all are built, a third with counterfactuals; else
#: fewer.
SAMPLE_SIZE, ENTITY_BUDGET = 12, 100
#: Minimum number of scenes built, half of them with counterfactuals.
MIN_SCENES = 4
#: Cost of planning one robot action, in entities.
ROBOT_ACTION_COST = 40
#: Maximum number of entities in all scenes of counterfactuals, and while those built before are built again.
MAX_CHANGED_ENTITIES, MAX_REPEATED_ENTITIES = 4_000, 2_000


@dataclass
class _ChangeBudget:
    """Bounds the scenes of counterfactuals, each of which has `work` entities."""

    work: int
    spent: int = 0
    built: set[str] = field(default_factory=set)

    def allows(self, change: Counterfactual) -> bool:
        """Whether one more scene may be built, which is counted then."""
        if self.spent >= (MAX_REPEATED_ENTITIES if change.name in self.built else MAX_CHANGED_ENTITIES):
            return False
        self.spent += self.work
        self.built.add(change.name)
        return True


def dry_run(spec: TaskSpec, report: Report) -> Design | None:
    """Report errors in the values of a spec; returns its design, or None if it has none."""
    linter, depend, design = Linter(), dependencies(spec), None
    with linter.collecting():
        linter.check(LintTask(spec, depend), (*task_rules.RULES, *giveaway_rules.TASK_RULES))
        design = Design(spec)
        linter.check(design, task_rules.DESIGN_RULES)
        instances = [design[index] for index in design.sample(SAMPLE_SIZE)]
        tried = [Evaluator(spec, instance.values, None, instance.key) for instance in instances]
        work = len(spec.things) + ROBOT_ACTION_COST * sum(
            thing.kind == "action" and bool(thing.of) for thing in spec.things
        )
        built = max(MIN_SCENES, SAMPLE_SIZE * ENTITY_BUDGET // max(ENTITY_BUDGET, work))
        budget, objects = _ChangeBudget(work), ObjectCache()
        for count, (values, instance) in enumerate(zip(tried[:built], instances, strict=False)):
            with linter.collecting():
                _lint_scene(
                    LintScene(values, depend, design, instance, objects),
                    linter,
                    budget if count < max(MIN_SCENES // 2, built // 3) else None,
                )
        for question in spec.questions:
            with linter.collecting():
                linter.check(SampledQuestion(question, tuple(tried)), option_rules.ALWAYS)
                linter.check(compare_options(question, design, depend), option_rules.RULES)
    report.include(with_source_text(linter.report.diagnostics))
    return design


def _lint_scene(scene: LintScene, linter: Linter, budget: _ChangeBudget | None) -> None:
    """Lint the scene of an instance, with its counterfactuals if there is a `budget` for them.

    Raises WmsError if it cannot be built.
    """
    spec, instance = scene.values.spec, scene.instance
    stage = episode.build_document(scene.values, scene.objects)
    linter.check(scene, scene_rules.RULES)
    linter.check(scene, plausible_rules.RULES)
    linter.check(scene, action_rules.RULES)
    linter.check(scene, hidden_rules.RULES)
    linter.check(scene, regime_rules.RULES)
    linter.check(scene, giveaway_rules.SCENE_RULES)
    things = {t.name for t in spec.things}
    for question in spec.questions if budget else ():
        for change in (*question.alternatives(instance.factors), *what_ifs(question, scene.values)):
            if (change.change == "levels" or change.owner in things) and budget and budget.allows(change):
                with linter.collecting():
                    otherwise = replace(scene, values=Evaluator(spec, instance.values, change, instance.key))
                    linter.check(ChangedScene(question, change, scene, stage, otherwise), change_rules.RULES)
