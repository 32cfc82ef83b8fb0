"""Creates a study of a dataset: selects questions, writes pictures, and assigns participants."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from wmspec.core.diagnostics import WmsError
from wmspec.core.rng import bits
from wmspec.core.safe_io import load_image, make_folders
from wmspec.dataset.build import files
from wmspec.dataset.build.files import with_remedies
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.models.question import Question, questions
from wmspec.eval.study import page, store
from wmspec.eval.study.model import PAGE_FOLDER, STUDY_FILE, Item, Kind, Step, Study, load, save

#: Words for attention checks.
_CHECK_WORDS = ("apple", "boat", "candle", "door", "feather", "garden", "hammer", "island")


@dataclass(frozen=True)
class StudyOptions:
    """The design of a study.

    Questions of each task, raters of each question, questions of each participant, practice of each task, questions for
    each attention check (0: none); and tasks and engines (all if empty).
    """

    per_task: int = 50
    raters: int = 3
    per_person: int = 100
    practice: int = 1
    check_every: int = 20
    seed: int = 0
    tasks: tuple[str, ...] = ()
    engines: tuple[str, ...] = ()


def make(dataset: DatasetReader, options: StudyOptions, folder: Path) -> Study:
    """Write a study to a folder; existing texts are kept.

    Raises WmsError if the dataset lacks a task or engine, or if the folder has answers to another study.
    """
    dataset.intact()
    shown = folder / PAGE_FOLDER
    chosen = dict(_chosen_questions(dataset, options))
    if "question" not in chosen.values():
        raise WmsError("the dataset has no questions for a study; `wmspec view` shows what it has")
    with with_remedies(folder):
        make_folders(shown / "pictures")
        items = [_item(question, chosen[question.id], shown) for question in questions(dataset, chosen)]
    items += _checks(options)
    study = Study(
        title=dataset.folder.resolve().name,
        dataset=files.digest(dataset.folder / files.MANIFEST),
        seed=options.seed,
        raters=options.raters,
        items=tuple(items),
        slots=slots(items, options.raters, options.per_person, options.check_every, options.seed),
    )
    if (folder / store.ANSWERS_FILE).exists() and (not (folder / STUDY_FILE).exists() or load(folder) != study):
        raise WmsError(f"{folder} has answers to another study; choose another folder with -o")
    save(study, folder)
    page.write(study, folder)
    return study


def _chosen_questions(dataset: DatasetReader, options: StudyOptions) -> Iterator[tuple[str, Kind]]:
    """Yield the ids of the questions, and the purpose of each. Practice questions are not repeated.

    Instances come in random order, with all their questions, each in one engine; several engines alternate.
    """
    if lacking := sorted(set(options.tasks) - set(dataset.tasks)):
        raise WmsError(f"the dataset has no task `{lacking[0]}`, but {', '.join(dataset.tasks)}")
    dataset.require_engines(options.engines)
    for task in options.tasks or dataset.tasks:
        ids: dict[tuple[int, int], dict[str, str]] = {}
        for row in dataset.rows(task, ["id", "index", "question", "engine"]):
            if not options.engines or row["engine"] in options.engines:
                ids.setdefault((row["index"], row["question"]), {})[row["engine"]] = row["id"]
        drawn = sorted(ids, key=lambda each: (bits(options.seed, "study", task, each[0]), each))
        turn = {index: i for i, index in enumerate(dict.fromkeys(index for index, _ in drawn))}
        shown = [_pick_engine(ids[each], turn[each[0]]) for each in drawn]
        practice = min(options.practice, len(shown) - 1)
        yield from ((id, "practice") for id in shown[:practice])
        yield from ((id, "question") for id in shown[practice : practice + options.per_task])


def _pick_engine(by_engine: dict[str, str], turn: int) -> str:
    engines = sorted(by_engine)
    return by_engine[engines[turn % len(engines)]]


def _item(question: Question, kind: Kind, shown: Path) -> Item:
    film, pictures = question.film, shown / "pictures"
    beside = [
        png for png, camera in zip(question.context, question.cameras, strict=True) if not film or camera != film.camera
    ]
    return Item(
        id=question.id,
        kind=kind,
        task=question.task,
        text=film.text if film else question.text,
        context=tuple(_write_picture(png, pictures) for png in beside),
        film=_write(film.mp4(), "mp4", shown / "films") if film else "",
        words=tuple(word for word in question.options if word is not None),
        pictures=tuple(_write_picture(png, pictures) for png in question.pictures),
        answer=question.answer,
        number=None if question.options else question.number,
        unit="" if question.options else question.unit,
        within=question.within,
        dimension=question.dimension,
        name=question.name,
        engine=question.engine,
        index=question.index,
        block=question.block,
    )


def _write_picture(png: bytes, folder: Path) -> str:
    """Write a picture under a name that reveals nothing about it."""
    load_image(png, "PNG")
    return _write(png, "png", folder)


def _write(content: bytes, suffix: str, folder: Path) -> str:
    name = f"{hashlib.sha256(content).hexdigest()[:20]}.{suffix}"
    if not (folder / name).exists():
        make_folders(folder)
        (folder / name).write_bytes(content)
    return name


def _checks(options: StudyOptions) -> Iterator[Item]:
    """Yield as many attention checks as a participant can meet."""
    for number in range(-(-options.per_person // options.check_every) if options.check_every else 0):
        words = sorted(_CHECK_WORDS, key=lambda word: bits(options.seed, "check", number, word))[:4]
        answer = bits(options.seed, "check", number) % 4
        text = f"This one only checks that questions are read: please choose “{words[answer]}”."
        yield Item(id=f"check/{number}", kind="check", task="", text=text, words=tuple(words), answer=answer)


def slots(items: Sequence[Item], raters: int, most: int, every: int, seed: int) -> tuple[tuple[Step, ...], ...]:
    """Return the steps of every participant.

    In each of `raters` rounds, all questions are divided evenly among as few participants as can answer at most `most`
    each. A participant answers task after task, so that instructions are read once. The order of tasks, and of
    questions within them, differs between rounds. Practice comes before a task's questions, and an attention check once
    among `every` questions (0: never).
    """
    question_indices = [i for i, item in enumerate(items) if item.kind == "question"]
    people = -(-len(question_indices) // most)
    made = []
    for round_ in range(raters):
        turned = _rotations(items, round_)
        order = sorted(
            question_indices, key=lambda i: (bits(seed, "task", round_, items[i].task), bits(seed, "item", round_, i))
        )
        for person in range(people):
            share = order[len(order) * person // people : len(order) * (person + 1) // people]
            made.append(tuple(_steps(items, share, turned, every, (seed, round_, person))))
    return tuple(made)


def _rotations(items: Sequence[Item], round_: int) -> dict[int, int]:
    """Return the rotation of each item's options in a round.

    The truth takes every position equally often among a task's questions with equally many options, and another one in
    every round.
    """
    counted: dict[tuple[str, int], int] = {}
    turned = {}
    for i, item in enumerate(items):
        count = len(item.options)
        if item.answer is None or not count:
            turned[i] = 0
            continue
        place = counted[item.task, count] = counted.get((item.task, count), -1) + 1
        turned[i] = (item.answer - place - round_) % count
    return turned


def _steps(
    items: Sequence[Item], share: Sequence[int], turned: dict[int, int], every: int, key: tuple[int, ...]
) -> Iterator[Step]:
    practice = {
        task: list(its) for task, its in groupby(_indices_of_kind(items, "practice"), key=lambda i: items[i].task)
    }
    checks, task = iter(_indices_of_kind(items, "check")), ""
    for answered, i in enumerate(share):
        if items[i].task != task:
            task = items[i].task
            yield from (Step(item=p, permutation=turned[p]) for p in practice.get(task, ()))
        if every and answered % every == bits("check", *key, answered // every) % every:
            check = next(checks)
            yield Step(item=check, permutation=bits("check", *key, check) % len(items[check].options))
        yield Step(item=i, permutation=turned[i])


def _indices_of_kind(items: Sequence[Item], kind: str) -> list[int]:
    """Return the indices of the items of a kind."""
    return [i for i, item in enumerate(items) if item.kind == kind]
