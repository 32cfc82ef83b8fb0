"""The audit of films: clips that need no model must score as they should."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.dataset.audit.model import Finding
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.clips.decide import decide
from wmspec.eval.clips.measure import measure
from wmspec.eval.clips.questions import FilmQuestion, closed_sets, film_questions, reference_of
from wmspec.eval.clips.read import BadClip
from wmspec.eval.clips.reference import Reference
from wmspec.eval.clips.sources import BASELINES, Baseline, open_baseline
from wmspec.eval.models.question import Selection

#: The name of the check.
CHECK = "films"
#: Number of closed sets of each task whose clips are scored.
SETS_PER_TASK = 3
#: Least share of right answers of true futures, and share of answers of clips without a future that is too large.
MIN_RIGHT, TOO_MANY_ANSWERS = 0.99, 0.05
#: By this much above chance, a clip of constant velocities may be right.
LINEAR_MARGIN = 0.05
#: The baselines that must be right, and those that must answer nothing.
TRUE_FUTURES, NO_FUTURES = ("oracle", "engine"), ("frozen", "blend", "swap")
#: Of each clip of a baseline that was read: whether it was answered, whether it was right, and the chance of guessing.
_Scores = list[tuple[bool, bool, float]]


def film_findings(dataset: DatasetReader) -> list[Finding]:
    """Return the findings about the films of each task; none for a dataset without films.

    At most `SETS_PER_TASK` closed sets of a task are scored. Raises WmsError if OpenCV is missing.
    """
    if dataset.film is None:
        return []
    every, findings = list[FilmQuestion](), list[Finding]()
    for task in dataset.tasks:
        try:
            every += film_questions(dataset, Selection((task,)).ids(dataset))
        except WmsError as error:
            findings.append(Finding(CHECK, task, "fails", str(error)))
    for task in dict.fromkeys(question.task for question in every):
        try:
            findings += _findings(dataset, task, every)
        except WmsError as error:
            findings.append(Finding(CHECK, task, "fails", str(error)))
    return findings


def _findings(dataset: DatasetReader, task: str, every: list[FilmQuestion]) -> Iterator[Finding]:
    """Yield the findings about the films of a task."""
    sets = closed_sets([question for question in every if question.task == task], SETS_PER_TASK)
    sources = {name: open_baseline(name, dataset, every) for name in BASELINES}
    scores: dict[str, _Scores] = {name: [] for name in BASELINES}
    for questions in sets:
        reference = reference_of(dataset, questions[0])
        for question in questions:
            for name, source in sources.items():
                _score(source, question, reference, scores[name])
    yield from (_judged(task, name, score) for name, score in scores.items() if score)
    moving = [question.moving for questions in sets for question in questions]
    if moving:
        what = f"in the part that is shown, something moves in {min(moving)} frames or more"
        yield Finding(CHECK, task, "holds" if min(moving) else "fails", what)


def _score(source: Baseline, question: FilmQuestion, reference: Reference, scores: _Scores) -> None:
    """Add the clip of a question; a baseline without one is left out."""
    try:
        clip, begins = source.clip(question, 0, reference)
    except BadClip:
        return
    choice = decide(measure(clip, reference, question.own, begins), question.rate).choice
    scores.append((choice is not None, choice == question.answer, 1 / len(question.films)))


def _judged(task: str, name: str, scores: _Scores) -> Finding:
    """Return the finding about a baseline."""
    answered, right, chance = np.mean(scores, axis=0).tolist()
    if name in TRUE_FUTURES:
        what, good = f"{right:.0%} right, {MIN_RIGHT:.0%} required", right >= MIN_RIGHT
    elif name in NO_FUTURES:
        what, good = f"{answered:.0%} answered, less than {TOO_MANY_ANSWERS:.0%} required", answered < TOO_MANY_ANSWERS
    else:
        limit = chance + LINEAR_MARGIN
        good = right <= limit + 1e-9
        what = f"{right:.0%} right, at most {limit:.0%} required: constant velocities must not be enough"
    return Finding(CHECK, task, "holds" if good else "fails", f"`clips:@{name}`: {what} ({len(scores):,} clips)")
