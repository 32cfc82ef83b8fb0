"""Results of a crosscheck as sentences."""

from __future__ import annotations

from math import degrees

from wmspec.runtime.compare.model import Cause, Comparison, Failure, Gap, Verdict
from wmspec.runtime.questions.kinds import KINDS


def failure(failed: Failure) -> str:
    """Return why an instance was not executed."""
    return ", ".join(part for part in (failed.engine, failed.run) if part) + f": {failed.reason}"


def dispute(verdict: Verdict) -> str:
    """Return how and why an answer differs."""
    why = (
        cause(verdict.cause)
        if verdict.cause
        else f"the trajectories agree within tolerance: {KINDS[verdict.kind].remedy(verdict.sort)}"
    )
    gate = "".join(f"; {e} would not ask it ({r})" for e, r in zip(verdict.engines, verdict.rejected, strict=True) if r)
    return f"question {verdict.question + 1}, {' and '.join(verdict.engines)}: {verdict.detail}{gate}; {why}"


def parting(comparison: Comparison) -> str:
    """Return how and why an episode is out of tolerance."""
    parts = [_apart(g) for g in comparison.gaps if g.began is not None]
    parts += [
        f"{e.first} and {e.second} touch {_when(e.times, comparison.engines)}"
        for e in comparison.events
        if not e.within
    ]
    parts += [
        f"{r.body} ends at rest in one alone ({r.speeds[0] * 100:.1f} and {r.speeds[1] * 100:.1f} cm/s)"
        for r in comparison.rests
    ]
    why = f"; {cause(comparison.cause)}" if comparison.cause else ""
    return f"{comparison.run}, {' and '.join(comparison.engines)}: {', '.join(parts)}{why}"


def cause(why: Cause) -> str:
    """Return where a divergence began and its cause."""
    where = f"`{why.body}` diverges at {why.began:.3f} s" + ("" if why.run == "truth" else f" in `{why.run}`")
    if why.mass is None or why.touched is None:
        return f"{where}: {why.hint}"
    masses = " and ".join(f"{m * 1000:.4g} g" if m else "fixed" for m in why.mass)
    return (
        f"{where}, after touching `{why.other}` at {why.touched:.3f} s "
        f"(mass {masses}, friction {why.friction:.3g}, restitution {why.restitution:.3g}): {why.hint}"
    )


def _apart(gap: Gap) -> str:
    allowed = f"{gap.allowed * 100:.1f} cm allowed"
    return f"{gap.body} up to {gap.position * 100:.1f} cm ({allowed}) and {degrees(gap.angle):.0f} deg apart"


def _when(times: tuple[float | None, float | None], engines: tuple[str, str]) -> str:
    return ", ".join(
        f"at {t:.3f} s in {e}" if t is not None else f"never in {e}" for t, e in zip(times, engines, strict=True)
    )
