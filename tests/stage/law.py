"""The law of one factor: what differs between two stages is what the spec makes depend on what was changed."""

from __future__ import annotations

from wmspec.compile.design.depend import Dependencies
from wmspec.compile.stage.document import Document


def violations(depend: Dependencies, before: Document, after: Document, *changed: str) -> tuple[str, ...]:
    """The paths of the properties that differ between two stages though nothing makes them depend on `changed`.

    `changed` are names of factors, or what `changed_by` a counterfactual.
    """
    return tuple(
        path
        for path, sources in before.differing(after).items()
        if not any(depend.source(source).intersection(changed) for source in sources)
    )
