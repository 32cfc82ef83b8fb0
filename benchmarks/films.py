"""Scoring of clips: damaged futures, clips that show none of the futures, and the time that a clip takes.

    python -m benchmarks.films DATASET [--task NAME ...] [--sets 2] [--keep FOLDER] [--page docs/benchmarks/films.md]
        [--note TEXT]

DATASET has films of several tasks. Every film of some closed sets is damaged in each way of `tests/films/corrupt.py`:
after some damage it still shows its future, after other damage none. Baselines need no clip. Then `evaluate` scores
two models with a known answer: one that ignores the state, and one with a constant bias for each future.

The results of each task are kept in FOLDER (DATASET.films by default), and a task whose results are there is not
repeated. The page has all tasks in FOLDER, also those of other datasets.
"""

from __future__ import annotations

import argparse
import csv
import json
import platform
import resource
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path

from tests.films.corrupt import KEEPS, SPOILS, Original
from wmspec import __version__
from wmspec.core.parquet_io import read_table
from wmspec.dataset.build.films import read_frames
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.film.codec import encode_mp4
from wmspec.eval.clips.decide import Decision, decide
from wmspec.eval.clips.measure import measure
from wmspec.eval.clips.questions import FilmQuestion, closed_sets, film_questions, reference_of
from wmspec.eval.clips.read import BadClip, Clip
from wmspec.eval.clips.reference import Reference
from wmspec.eval.clips.results import RULES_VERSION
from wmspec.eval.clips.run import ClipRun, evaluate_clips
from wmspec.eval.clips.sources import BASELINES, open_baseline
from wmspec.eval.clips.surprise import SurpriseRun, evaluate_surprises
from wmspec.eval.models.question import Selection

#: The end of the names of files with what `evaluate` makes of models.
EVALUATED = ".evaluated.json"
#: What becomes of a clip.
RIGHT, WRONG, NONE = "right", "wrong", "none"


@dataclass(frozen=True)
class Scored:
    """A clip: its damage or baseline, the outcome, and the reasons for no answer."""

    damage: str
    outcome: str
    why: tuple[str, ...]


@dataclass
class TaskScores:
    """The outcomes of a task's clips."""

    task: str
    sets: int
    seed: int
    rules: int = RULES_VERSION
    scored: list[Scored] = field(default_factory=list)


@dataclass
class Evaluated:
    """What `evaluate` makes of models with a known answer.

    `ignorant` counts the outcomes of a model that ignores the state, and how many of its answers are the future of the
    other state. `latent` has the number of answers of a latent model with a bias, and of those right raw and centred.
    `seconds` is the processor time of the first for a clip, without what a run does once, and `frames` is the number
    of frames of a clip after the context. `clips` were scored.
    """

    ignorant: dict[str, int] = field(default_factory=dict)
    latent: dict[str, int] = field(default_factory=dict)
    seconds: float = 0.0
    clips: int = 0
    frames: float = 0.0


def main() -> None:
    """Score clips, print what went wrong, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dataset", type=Path)
    parser.add_argument("--task", action="append", help="only this task; may be repeated")
    parser.add_argument("--sets", type=int, default=2, help="closed sets of each task")
    parser.add_argument("--keep", type=Path, help="the folder of the results of tasks")
    parser.add_argument("--page", type=Path)
    parser.add_argument("--note", default="", help="a sentence on the page about the groups")
    chosen = parser.parse_args()
    folder = chosen.keep or chosen.dataset.with_name(f"{chosen.dataset.name}.films")
    folder.mkdir(parents=True, exist_ok=True)
    dataset = DatasetReader.open(chosen.dataset)
    every = list(film_questions(dataset, Selection().ids(dataset)))
    tasks = tuple(chosen.task or dict.fromkeys(question.task for question in every))
    for task in tasks:
        path = folder / f"{task}.{chosen.dataset.name}.json"
        if not path.exists():
            path.write_text(json.dumps(asdict(scores(dataset, task, chosen.sets, every))), encoding="utf-8")
    path = folder / f"{chosen.dataset.name}{EVALUATED}"
    if not path.exists():
        path.write_text(json.dumps(asdict(evaluated(dataset, tasks))), encoding="utf-8")
    kept = sorted(folder.glob("*.json"))
    text = page(
        [_read(path) for path in kept if not path.name.endswith(EVALUATED)],
        [Evaluated(**json.loads(path.read_text(encoding="utf-8"))) for path in sorted(folder.glob(f"*{EVALUATED}"))],
        chosen.note,
    )
    print(text)
    if chosen.page:
        chosen.page.write_text(text, encoding="utf-8")


def _read(path: Path) -> TaskScores:
    known = json.loads(path.read_text(encoding="utf-8"))
    return TaskScores(**{**known, "scored": [Scored(**{**one, "why": tuple(one["why"])}) for one in known["scored"]]})


def scores(dataset: DatasetReader, task: str, sets: int, every: list[FilmQuestion]) -> TaskScores:
    """Return the outcomes of every damage and baseline on some closed sets of a task."""
    chosen = closed_sets([question for question in every if question.task == task], sets)
    made = TaskScores(task, len(chosen), dataset.manifest["seed"])
    for questions in chosen:
        reference = reference_of(dataset, questions[0])
        for question in questions:
            made.scored += _of_question(question, reference, dataset, every)
            print(f"{task}: {len(made.scored)} clips", flush=True)
    return made


def _of_question(
    question: FilmQuestion, reference: Reference, dataset: DatasetReader, every: list[FilmQuestion]
) -> Iterator[Scored]:
    for name, damage in {**KEEPS, **SPOILS}.items():
        clip = damage(Original(reference, question.own))
        yield _scored(question, name, _decided(clip, reference, question))
    for name in BASELINES:
        try:
            clip, begins = open_baseline(name, dataset, every).clip(question, 0, reference)
        except BadClip:
            continue
        yield _scored(question, f"@{name}", _decided(clip, reference, question, begins))


def _decided(clip: Clip, reference: Reference, question: FilmQuestion, begins: object = None) -> Decision:
    return decide(measure(clip, reference, question.own, begins), question.rate)  # type: ignore[arg-type]


def _scored(question: FilmQuestion, damage: str, decision: Decision) -> Scored:
    outcome = NONE if decision.choice is None else RIGHT if decision.choice == question.answer else WRONG
    expected = NONE if damage in SPOILS or damage in ("@frozen", "@blend", "@swap") else RIGHT
    if outcome != expected and damage != "@linear":
        print(f"{question.id} {damage}: {outcome} {', '.join(decision.why)}", flush=True)
    return Scored(damage, outcome, decision.why)


# ---------------------------------------------------------------- models with a known answer


def evaluated(dataset: DatasetReader, tasks: tuple[str, ...]) -> Evaluated:
    """Return what `evaluate` makes of models with a known answer, on all questions of some tasks."""
    made = Evaluated()
    questions = list(film_questions(dataset, Selection(tasks).ids(dataset)))
    with tempfile.TemporaryDirectory() as folder:
        _evaluate_ignorant(dataset, tasks, questions, Path(folder), made)
        _evaluate_biased(dataset, tasks, questions, Path(folder), made)
    return made


def _evaluate_ignorant(
    dataset: DatasetReader, tasks: tuple[str, ...], questions: list[FilmQuestion], folder: Path, made: Evaluated
) -> None:
    """Score a model that answers two questions that differ in the state alone with the same film."""
    kinds = {row["id"]: row["option_kind"] for task in tasks for row in dataset.rows(task, ["id", "option_kind"])}
    (folder / "clips").mkdir()
    for question in questions:
        sibling = question.films[kinds[question.id].index("state")]
        frames = read_frames(dataset.folder, min(question.film, sibling), count=question.answer_frame + 1)
        content = encode_mp4(frames[question.context - 1 :], question.rate, 20)
        (folder / "clips" / f"{question.file_name}.mp4").write_bytes(content)
        made.frames += (len(frames) - question.context) / len(questions)
    run, times = ClipRun(dataset, str(folder / "clips"), Selection(tasks)), list[float]()
    before = _ended_processor_time()
    evaluate_clips(run, folder / "i.parquet", lambda *_: times.append(time.process_time()))
    decoding = (_ended_processor_time() - before) / len(times)
    # From the end of the first closed set on: before, packages are imported.
    first = len(questions[0].films)
    made.seconds = (times[-1] - times[first - 1]) / (len(times) - first) + decoding
    rows = read_table(folder / "i.parquet").to_pylist()
    made.clips = len(rows)
    outcomes = [NONE if row["parsed"] is None else RIGHT if row["right"] else WRONG for row in rows]
    made.ignorant = dict(Counter(outcomes)) | {
        "state": sum(row["parsed"] is not None and kinds[row["id"]][row["parsed"]] == "state" for row in rows)
    }


def _ended_processor_time() -> float:
    """Return the processor time (s) of processes that this one has ended: those that decode clips."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _evaluate_biased(
    dataset: DatasetReader, tasks: tuple[str, ...], questions: list[FilmQuestion], folder: Path, made: Evaluated
) -> None:
    """Score a latent model that a wrong future surprises by 1, and each future also by its own constant."""
    with (folder / "surprises.csv").open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(["id", "place", "frame", "surprise"])
        for question in questions:
            biases = {path: 10 * rank for rank, path in enumerate(sorted(question.films))}
            for place, path in enumerate(question.films):
                out.writerow([question.id, place, "", (place != question.answer) + biases[path]])
    run = SurpriseRun(dataset, f"surprises:{folder / 'surprises.csv'}", Selection(tasks))
    evaluate_surprises(run, folder / "b.parquet", lambda *_: None)
    rows = read_table(folder / "b.parquet").to_pylist()
    right = Counter(row["prompt"] for row in rows if row["right"])
    made.latent = {"answers": len(rows) // 2, "raw": right["raw"], "centred": right["centred"]}


# ---------------------------------------------------------------- page

#: What the page measures.
INTRODUCTION = """\
wmspec decides by [rules](../guides/video_models.md#how-a-clip-is-scored) which future the clip of a video model
shows, or that it shows none. This page measures how often the rules are right. The benchmark takes clips whose future
is known, damages them, and scores them like clips of a model. *Damaged futures* still show their future. *Clips
without a future* are damaged until they show none. Names with `@` are
[baselines](../guides/video_models.md#4-score-and-report).

The columns *right*, *wrong* and *none* give the share of clips for which the rules choose the true future, another
future, or none. *None* is the correct outcome for clips without a future, and for `@frozen`, `@blend` and `@swap`.
"""
#: What the models with known answers are.
SIMULATED_MODELS = """\
Two simulated models have known weaknesses, which `wmspec evaluate` should show. The futures of a closed set result
from the levels of two factors, a state (such as a mass) and an action. The first model ignores the state: it makes
the same clip for two questions that differ only in the state, so it can be right in half of its answers. Answers that
are neither right nor wrong are *none*. The second is a [latent model](../guides/video_models.md#latent-models). A
wrong future surprises it more than the true one, but each future has a constant bias that exceeds this difference.
`raw` scores should suffer from the bias, and `centred` scores should not.
"""
#: What each damage is.
KINDS_OF_DAMAGE = """\
Each cell has the number of clips that are right, the number that are wrong and the number without a choice (right /
wrong / none). The rows from *undamaged* to *jitter* are damaged futures, those from *frozen* to *other scene* are
clips without a future.

- *h264 at 38* is strong compression. *Other rate* has 1.25 times as many frames per second; *slower* and *faster*
  change the tempo by the factor 1.15.
- In *drift* the camera moves and zooms. In *shrinks*, *deforms* and *jitter*, the objects lose size, change their
  proportions or shake.
- *Frozen* repeats the first frame. *Mixture* is the mean of two futures. In *vanishes* the objects disappear
  half-way, in *morph* they fade into the background. *Other scene* shows the future upside down, shifted and in
  inverted colours.
"""


def page(tasks: list[TaskScores], models: list[Evaluated], note: str) -> str:
    """Return the page of results."""
    scored, names = [one for task in tasks for one in task.scored], sorted({task.task for task in tasks})
    clips = sum(one.clips for one in models)
    seconds, frames = (sum(getattr(one, name) * one.clips for one in models) / clips for name in ("seconds", "frames"))
    ignorant, latent = (
        sum((Counter(each) for each in counts), Counter[str]())
        for counts in ([one.ignorant for one in models], [one.latent for one in models])
    )
    answers = max(1, latent["answers"])
    lines = [
        "# Scoring films",
        "",
        INTRODUCTION,
        *([note, ""] if note else []),
        (
            "`python -m benchmarks.films DATASET --page docs/benchmarks/films.md` wrote this page with wmspec "
            f"{__version__}, version {RULES_VERSION} of the rules and"
        ),
        f"Python {platform.python_version()}.",
        "",
        "| kind of clip | clips | right | wrong | none |",
        "|---|---|---|---|---|",
        _line("damaged futures", [one for one in scored if one.damage in KEEPS]),
        _line("clips without a future", [one for one in scored if one.damage in SPOILS]),
        *(_line(f"`{name}`", [one for one in scored if one.damage == name]) for name in (f"@{b}" for b in BASELINES)),
        "",
        "In the next table, *right*, *wrong* and *none* are shares of the number of clips to their left.",
        "",
        (
            "| seed of the dataset | damaged futures | right | wrong "
            "| clips without a future | none | clips of `@engine` | right |"
        ),
        "|---|---|---|---|---|---|---|---|",
        *(_of_seed(seed, [task for task in tasks if task.seed == seed]) for seed in sorted({t.seed for t in tasks})),
        "",
        (
            f"`wmspec evaluate` takes {seconds:.2f} s of processor time for a clip of {frames:.0f} frames, or "
            f"{1000 * seconds / 60:.1f} minutes for 1,000 clips. This includes the decoding"
        ),
        "of the clip and of the films of its closed set.",
        "",
        SIMULATED_MODELS,
        "| model with known answers | answers | right | wrong answers |",
        "|---|---|---|---|",
        (
            f"| a video model that ignores the state | {clips} | {ignorant[RIGHT] / max(1, clips):.0%} "
            f"| {ignorant['state']} of {ignorant[WRONG]} are the future of the other state |"
        ),
        *(
            f"| a latent model with a constant bias for each future, scored as `{name}` | {answers} "
            f"| {latent[name] / answers:.0%} | |"
            for name in ("raw", "centred")
        ),
        "",
        "## Damage",
        "",
        KINDS_OF_DAMAGE,
        "| damage or baseline | " + " | ".join(f"`{name}`" for name in names) + " |",
        "|---" * (len(names) + 1) + "|",
    ]
    for damage in (*KEEPS, *SPOILS, *(f"@{b}" for b in BASELINES)):
        cells = [_cell([s for t in tasks if t.task == name for s in t.scored if s.damage == damage]) for name in names]
        shown = f"`{damage}`" if damage[0] == "@" else "undamaged" if damage == "none" else damage
        lines.append(f"| {shown} | " + " | ".join(cells) + " |")
    lines.append(
        "| number of closed sets | " + " | ".join(str(sum(t.sets for t in tasks if t.task == n)) for n in names) + " |"
    )
    return "\n".join([*lines, ""])


def _of_seed(seed: int, tasks: list[TaskScores]) -> str:
    """Return the row of a seed."""
    scored = [one for task in tasks for one in task.scored]
    kept, spoiled, engine = (
        [one.outcome for one in scored if one.damage in names] for names in (KEEPS, SPOILS, ("@engine",))
    )
    cells = [f"{seed}", f"{len(kept):,}", _share(kept, RIGHT), _share(kept, WRONG)]
    cells += [f"{len(spoiled):,}", _share(spoiled, NONE), f"{len(engine):,}", _share(engine, RIGHT)]
    return "| " + " | ".join(cells) + " |"


def _share(outcomes: list[str], one: str) -> str:
    return f"{outcomes.count(one) / max(1, len(outcomes)):.1%}"


def _line(name: str, scored: list[Scored]) -> str:
    outcomes = [one.outcome for one in scored]
    return f"| {name} | {len(scored):,} | " + " | ".join(_share(outcomes, o) for o in (RIGHT, WRONG, NONE)) + " |"


def _cell(scored: list[Scored]) -> str:
    counts = Counter(one.outcome for one in scored)
    return " / ".join(str(counts[outcome]) for outcome in (RIGHT, WRONG, NONE)) if scored else ""


if __name__ == "__main__":
    main()
