"""One-line summaries of tasks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from wmspec.dataset.audit.model import Finding, Probe, Summary


def summary(
    task: str, questions: int, groups: Mapping[str, int], findings: Sequence[Finding], probes: Sequence[Probe],
    stable: float | None,
) -> Summary:  # fmt: skip
    """Return the summary of a task.

    `findings` and `probes` cover all its questions; `groups` maps each question to its number of groups.
    """
    wrong, unknown = (dict.fromkeys(f.check for f in findings if f.verdict == v) for v in ("fails", "unclear"))
    judged = [p for p in probes if p.judged]
    best = max(judged, key=lambda p: p.accuracy - p.chance, default=None)
    return Summary(
        task=task,
        verdict="fails" if wrong else "unclear" if unknown else "holds",
        why=tuple(wrong or unknown),
        questions=questions,
        groups=min(groups.values(), default=0),
        above=best.accuracy - best.chance if best else None,
        best=best.sees if best else "",
        least=max((p.least for p in judged), default=None),
        stable=stable,
    )
