"""Baselines: known disagreements, kept in a JSON file beside the specs. Only new ones fail a crosscheck."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wmspec.compile.design.levels import Level
from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes
from wmspec.runtime.compare.disagreement import Disagreement, Identity
from wmspec.runtime.compare.model import CheckResult
from wmspec.runtime.compare.sweep import SweepConfig

#: Version of the file layout.
FORMAT = 1


@dataclass(frozen=True)
class Baseline:
    """Known disagreements of crosschecks with this `seed`."""

    seed: int
    known: tuple[Disagreement, ...] = ()

    @property
    def identities(self) -> frozenset[Identity]:
        """The identities of the known disagreements."""
        return frozenset(d.identity for d in self.known)

    def vanished(
        self, current: Iterable[Disagreement], job: SweepConfig, checked: Sequence[CheckResult]
    ) -> tuple[Disagreement, ...]:
        """Return the known disagreements that this crosscheck would have found, and did not find.

        Those of tasks, instances and engines that it did not execute are not among them.
        """
        now = {d.identity for d in current}
        executed = {(c.task, c.index) for c in checked}
        return tuple(
            d
            for d in self.known
            if d.identity not in now and (d.task, d.index) in executed and set(d.engines) <= set(job.engines)
        )

    def updated(self, current: Iterable[Disagreement], vanished: Collection[Disagreement]) -> Baseline:
        """Return the baseline with the current disagreements and without those that vanished."""
        gone = {d.identity for d in vanished}
        kept = {d.identity: d for d in self.known if d.identity not in gone}
        every = kept | {d.identity: d for d in current}
        return Baseline(self.seed, tuple(sorted(every.values(), key=_order)))

    def text(self) -> str:
        """Return the content of the file: one entry a line, in order, so that its changes are easy to review."""
        entries = ",\n".join(f"    {json.dumps(_entry(d), ensure_ascii=False)}" for d in self.known)
        known = f"[\n{entries}\n  ]" if entries else "[]"
        return f'{{\n  "format": {FORMAT},\n  "seed": {self.seed},\n  "known": {known}\n}}\n'


def read_baseline(path: Path, seed: int) -> Baseline:
    """Return the baseline in a file. Raises WmsError if it cannot be read, or is that of another seed."""
    place = FilePlace(str(path))
    try:
        record = json.loads(read_bytes(path))
        if record["format"] != FORMAT:
            raise WmsError(f"its format is {record['format']!r}; this version of wmspec reads {FORMAT}", place)
        baseline = Baseline(int(record["seed"]), tuple(map(_disagreement, record["known"])))
    except FileNotFoundError:
        raise WmsError("there is no such baseline", place, "add --update-baseline to write it") from None
    except OSError as error:
        raise WmsError(f"cannot be read: {error.strerror}", place) from None
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise WmsError("this is no baseline", place, "write it again with --update-baseline") from None
    if baseline.seed != seed:
        raise WmsError(f"it holds the disagreements of seed {baseline.seed}, not {seed}", place, "use another file")
    return baseline


def _entry(d: Disagreement) -> dict[str, Any]:
    return {
        "task": d.task,
        "instance": d.index,
        "factors": d.factors,
        "kind": d.kind,
        "engines": d.engines,
        "run": d.run,
        "question": None if d.question is None else d.question + 1,
        "reason": d.reason,
    }


def _disagreement(entry: dict[str, Any]) -> Disagreement:
    question, kind = entry["question"], entry["kind"]
    if kind not in ("failure", "answers", "trajectories") or not isinstance(entry["task"], str):
        raise ValueError(kind)
    factors: dict[str, Level] = {str(k): tuple(v) if isinstance(v, list) else v for k, v in entry["factors"].items()}
    return Disagreement(
        entry["task"],
        int(entry["instance"]),
        factors,
        kind,
        tuple(map(str, entry["engines"])),
        str(entry["run"]),
        None if question is None else int(question) - 1,
        str(entry["reason"]),
    )


def _order(d: Disagreement) -> tuple[object, ...]:
    return d.task, d.index, d.kind, -1 if d.question is None else d.question, d.engines, d.run
