"""Running probes on the questions of a task: what a probe is, its result, and the best of several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit import power
from wmspec.dataset.audit.cases import Case
from wmspec.dataset.audit.classify import Array, ProbeDataset, ProbeFeatures, cross_validated_scores, top1_score
from wmspec.dataset.audit.model import Probe
from wmspec.dataset.audit.probe_selection import CandidateProbes

Look = Callable[[], ProbeFeatures]
Family = Literal["text", "options", "rule", "combination", "picture", "pair", "pictures"]


@dataclass(frozen=True)
class ProbeSpec:
    """A probe to be run. Its input is computed on demand."""

    sees: str
    family: Family
    judged: bool
    why: str
    seen: Look | None = None
    scores: Array | None = None  # set for a rule, which is not fitted
    pictured: bool = False  # sees a context picture, so options may be eliminated (`state.eliminated_options`)
    competes: bool = False  # competes for selection as the best probe


@dataclass(frozen=True)
class ProbedQuestions:
    """The probed questions of a task. `kept` (options,) are those of all options that are alternatives."""

    name: str
    data: ProbeDataset
    kept: NDArray[np.bool_]

    @classmethod
    def of(
        cls, name: str, cases: Sequence[Case], groups: Sequence[str], struck: Sequence[NDArray[np.bool_]]
    ) -> ProbedQuestions:
        """Return the questions without eliminated options; `struck` (options,) marks these in each question."""
        kept = ~np.concatenate(struck)
        truth = [np.arange(c.count) == c.row["answer"] for c in cases]
        data = ProbeDataset(
            owner=np.repeat(np.arange(len(cases)), [c.count for c in cases])[kept],
            name=np.array([name for c in cases for name in _classes(c)])[kept],
            truth=np.concatenate(truth)[kept],
            groups=groups,
        )
        return cls(name, data, kept)

    def probe(self, line: ProbeSpec) -> Probe:
        """Return the result of a probe."""
        if line.scores is not None:
            return self._result(line, top1_score(line.scores[self.kept], self.data))
        seen = self._seen(line)
        learned = power.learned_gains(seen, self.data, 1 / self.data.sizes) if line.judged else None
        return self._result(line, cross_validated_scores(seen, self.data), learned)

    def rivals(self, best: str, why: str, lines: Sequence[ProbeSpec]) -> list[Probe]:
        """Return the results of competing probes, and of the best of them, which is judged.

        `best` is its name, with a place `{}` for the name of the probe that is selected most often.
        """
        # Cached: every injection uses the same features, which are small and costly to compute.
        seen = [cache(partial(self._seen, line)) for line in lines]
        rivals = CandidateProbes.of(seen, self.data)
        right, picked = rivals.best(self.data)
        commonest = lines[int(np.bincount(picked).argmax())].sees
        winner = replace(lines[0], sees=best.format(commonest), judged=True, why=why)
        learned = rivals.learned(seen, self.data, 1 / self.data.sizes)
        each = [self._result(line, answered) for line, answered in zip(lines, rivals.right, strict=True)]
        return [*each, self._result(winner, right, learned)]

    def _seen(self, line: ProbeSpec) -> ProbeFeatures:
        assert line.seen is not None
        seen = line.seen()
        return replace(seen, features=seen.features[self.kept]) if seen.of == "options" else seen

    def _result(self, line: ProbeSpec, right: Array, learned: tuple[float, ...] | None = None) -> Probe:
        chance = 1 / self.data.sizes
        return Probe(
            task=self.name,
            sees=line.sees,
            family=line.family,
            questions=len(right),
            right=float(right.sum()),
            chance=float(chance.mean()),
            deviation=power.deviation(right, chance, self.data.groups),
            judged=line.judged,
            why=line.why,
            learned=learned,
        )


def _classes(case: Case) -> list[str]:
    """Return the names of options across questions; positions for pictures, since their names reveal the truth."""
    return [str(i) for i in range(case.count)] if case.has_picture_options else case.row["option_name"]
