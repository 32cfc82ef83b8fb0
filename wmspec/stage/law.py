"""The law of one factor: what differs between two stages is what the spec makes depend on what was changed."""

from __future__ import annotations

from wmspec.design.depend import Dependencies
from wmspec.stage.document import Document


def violations(depend: Dependencies, before: Document, after: Document, changed: str) -> tuple[str, ...]:
    """The paths of the properties that differ between two stages though nothing makes them depend on `changed`.

    `changed` is the name of a factor, or the `owner.property` (or the action) that a counterfactual changes.
    """
    return tuple(
        path
        for path, sources in before.differing(after).items()
        if not any(changed in depend.source(source) for source in sources)
    )
