"""Assignment of questions to participants: pure functions of questions and seed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

from wmspec.core.rng import bits
from wmspec.eval.study.model import Item, Step


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
