"""What video models make: which of the futures, whether it follows state and action, and how exactly."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from wmspec.eval.report.intervals import Estimate, mean_estimates
from wmspec.eval.report.replies import CLIP_COLUMNS, Replies

#: A clip runs at another tempo if it differs from real time by more than this.
_REAL_TIME = 0.025


@dataclass(frozen=True)
class FilmScores:
    """The clips of a system for a task, or for all tasks ('').

    Shares of the clips: `right`; `state` and `action`, those that show a future with the true state or action;
    `sibling_state`, `sibling_action` and `sibling_both`, those that show the future of another state, action, or both;
    `none`, those that show none of the futures; `frozen`; `tempo`, those that run slower or faster. `forced` is the
    share whose nearest future is the true one. Errors are in object widths: `track_error` over the way, `final_error`
    at the end, and the floors, those between two engines (None if one engine has films). The others are means of the
    figures of Physics-IQ and WorldBench.
    """

    task: str
    system: str
    clips: int
    right: Estimate
    state: float
    action: float
    sibling_state: float
    sibling_action: float
    sibling_both: float
    none: float
    frozen: float
    tempo: float
    forced: float
    track_error: float
    final_error: float
    track_floor: float | None
    final_floor: float | None
    piq_spatial: float
    piq_spatiotemporal: float
    piq_weighted: float
    piq_mse: float
    miou: float
    background_rmse: float


def films(replies: Replies) -> tuple[FilmScores, ...]:
    """Return the scores of every system that made clips, for each task and for all. Requires the dataset."""
    table = replies.table
    if replies.questions is None or "nearest" not in table or table["nearest"].isna().all():
        return ()
    clips = table[table["nearest"].notna()]
    kinds = replies.questions.table["kinds"]
    made = [
        "none" if pd.isna(place) else kinds[name][int(place)]
        for name, place in zip(clips["id"], clips["parsed"], strict=True)
    ]
    clips = clips.assign(made=made)
    parts = pd.concat([clips.assign(part=""), clips.assign(part=clips["task"])])
    return tuple(
        _scores(str(task), str(system), p) for (task, system), p in parts.groupby(["part", "system"], sort=True)
    )


def _scores(task: str, system: str, clips: pd.DataFrame) -> FilmScores:
    (right,), _ = mean_estimates(clips[["right"]].to_numpy(), clips["cluster"], ("films", task, system))
    made = clips["made"]

    def share(*kinds: str) -> float:
        return float(made.isin(kinds).mean())

    def mean(column: str) -> float | None:
        known = clips[column].dropna().astype(float)
        return float(known.mean()) if len(known) else None

    floors = {name: mean(name) for name in ("track_floor", "final_floor")}
    means = {name: mean(name) for name in CLIP_COLUMNS[3:] if name not in floors}
    return FilmScores(
        task=task,
        system=system,
        clips=len(clips),
        right=right,
        state=share("truth", "action"),
        action=share("truth", "state"),
        sibling_state=share("state"),
        sibling_action=share("action"),
        sibling_both=share("both"),
        none=share("none"),
        frozen=float(clips["frozen"].eq(True).mean()),
        tempo=float((clips["tempo"].astype(float) - 1).abs().gt(_REAL_TIME).where(made != "none", False).mean()),
        forced=float((clips["nearest"].astype(int) == clips["answer"].astype(int)).mean()),
        track_floor=floors["track_floor"],
        final_floor=floors["final_floor"],
        **{name: float("nan") if value is None else value for name, value in means.items()},
    )
