"""Scoring of clips: damaged futures, clips that show none of the futures, and the time that a clip takes.

    python -m benchmarks.films DATASET [--sets 1] [--page docs/benchmarks/films.md]

DATASET has films of several tasks. Every film of some closed sets is damaged in each way of `tests/films/corrupt.py`:
after some damage it still shows its future, after other damage none. Baselines need no clip.
"""

from __future__ import annotations

import argparse
import platform
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.films.corrupt import KEEPS, SPOILS, Original
from wmspec import __version__
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.clips.decide import Decision, decide
from wmspec.eval.clips.measure import measure
from wmspec.eval.clips.questions import FilmQuestion, closed_sets, film_questions, reference_of
from wmspec.eval.clips.read import BadClip, Clip
from wmspec.eval.clips.reference import Reference
from wmspec.eval.clips.results import RULES_VERSION
from wmspec.eval.clips.sources import BASELINES, open_baseline
from wmspec.eval.models.question import Selection

#: What becomes of a clip.
RIGHT, WRONG, NONE = "right", "wrong", "none"


@dataclass(frozen=True)
class Scored:
    """A clip: its task, its damage or baseline, the outcome, and the reasons for no answer."""

    task: str
    damage: str
    outcome: str
    why: tuple[str, ...]


@dataclass
class Timer:
    """The time (CPU s) of scoring, without that of making the clips, and the number of frames and clips."""

    seconds: float = 0.0
    frames: int = 0
    clips: int = 0

    def decided(self, clip: Clip, reference: Reference, question: FilmQuestion, begins: object = None) -> Decision:
        """Return the decision on a clip."""
        start = time.process_time()
        decision = decide(measure(clip, reference, question.own, begins), question.rate)  # type: ignore[arg-type]
        self.seconds += time.process_time() - start
        self.frames += reference.count
        self.clips += 1
        return decision


def main() -> None:
    """Score clips, print what went wrong, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dataset", type=Path)
    parser.add_argument("--sets", type=int, default=1, help="closed sets of each task")
    parser.add_argument("--page", type=Path)
    chosen = parser.parse_args()
    timer = Timer()
    scored = list(scores(DatasetReader.open(chosen.dataset), chosen.sets, timer))
    text = page(scored, timer)
    print(text)
    if chosen.page:
        chosen.page.write_text(text, encoding="utf-8")


def scores(dataset: DatasetReader, sets: int, timer: Timer) -> Iterator[Scored]:
    """Yield the outcomes of every damage and baseline on some closed sets of each task."""
    every = list(film_questions(dataset, Selection().ids(dataset)))
    for task in dict.fromkeys(question.task for question in every):
        for questions in closed_sets([question for question in every if question.task == task], sets):
            reference = reference_of(dataset, questions[0])
            for question in questions:
                yield from _of_question(question, reference, dataset, every, timer)


def _of_question(
    question: FilmQuestion, reference: Reference, dataset: DatasetReader, every: list[FilmQuestion], timer: Timer
) -> Iterator[Scored]:
    for name, damage in {**KEEPS, **SPOILS}.items():
        clip = damage(Original(reference, question.own))
        yield _scored(question, name, timer.decided(clip, reference, question))
    for name in BASELINES:
        try:
            clip, begins = open_baseline(name, dataset, every).clip(question, 0, reference)
        except BadClip:
            continue
        yield _scored(question, f"@{name}", timer.decided(clip, reference, question, begins))


def _scored(question: FilmQuestion, damage: str, decision: Decision) -> Scored:
    outcome = NONE if decision.choice is None else RIGHT if decision.choice == question.answer else WRONG
    if outcome != RIGHT and damage in KEEPS:
        print(f"{question.id} {damage}: {outcome} {', '.join(decision.why)}", flush=True)
    return Scored(question.task, damage, outcome, decision.why)


# ---------------------------------------------------------------- page


def page(scored: list[Scored], timer: Timer) -> str:
    """Return the page of results."""
    tasks = list(dict.fromkeys(one.task for one in scored))
    per_clip = timer.seconds / max(1, timer.clips)
    kept = [one for one in scored if one.damage in KEEPS]
    spoiled = [one for one in scored if one.damage in SPOILS]
    lines = [
        "# Scoring films",
        "",
        (
            "Made by `python -m benchmarks.films DATASET --page docs/benchmarks/films.md` with wmspec "
            f"{__version__}, version {RULES_VERSION} of the rules and Python {platform.python_version()}."
        ),
        "",
        "A known future is damaged, and scored as the clip of a model. *Right* clips are recognized as their future,",
        "*wrong* ones are taken for another, and of the rest none of the futures is chosen.",
        "",
        "| | clips | right | wrong | none |",
        "|---|---|---|---|---|",
        _line("damaged futures", kept),
        _line("clips without a future", spoiled),
        *(_line(f"`{name}`", [one for one in scored if one.damage == name]) for name in (f"@{b}" for b in BASELINES)),
        "",
        (
            f"Scoring takes {per_clip:.2f} CPU s a clip of {timer.frames / max(1, timer.clips):.0f} frames: "
            f"{1000 * per_clip / 60:.1f} minutes for 1,000 clips."
        ),
        "",
        "## Damage",
        "",
        "Clips that are right, wrong and none, by task.",
        "",
        "| | " + " | ".join(f"`{task}`" for task in tasks) + " |",
        "|---" * (len(tasks) + 1) + "|",
    ]
    for name in (*KEEPS, *SPOILS, *(f"@{b}" for b in BASELINES)):
        cells = [_cell([one for one in scored if (one.task, one.damage) == (task, name)]) for task in tasks]
        lines.append(f"| {f'`{name}`' if name[0] == '@' else name} | " + " | ".join(cells) + " |")
    return "\n".join([*lines, ""])


def _line(name: str, scored: list[Scored]) -> str:
    counts = Counter(one.outcome for one in scored)
    shares = (f"{counts[outcome] / max(1, len(scored)):.1%}" for outcome in (RIGHT, WRONG, NONE))
    return f"| {name} | {len(scored):,} | " + " | ".join(shares) + " |"


def _cell(scored: list[Scored]) -> str:
    counts = Counter(one.outcome for one in scored)
    return " / ".join(str(counts[outcome]) for outcome in (RIGHT, WRONG, NONE)) if scored else ""


if __name__ == "__main__":
    main()
