"""Who is shown what: pure functions of the questions and a seed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

from wmspec.core.rng import bits
from wmspec.eval.study.model import Item, Step


def slots(items: Sequence[Item], raters: int, most: int, every: int, seed: int) -> tuple[tuple[Step, ...], ...]:
    """The steps of every person.

    In each of `raters` rounds all questions are dealt out, to as few people as can answer at most `most` each; their
    numbers of questions differ by no more than one. A person answers task after task, so that the rules are read once;
    tasks, and questions within them, come in another order in every round. Practice comes before a task's questions and
    a check of attention once among `every` questions (0: never).
    """
    asked = [i for i, item in enumerate(items) if item.kind == "question"]
    people = -(-len(asked) // most)
    made = []
    for round_ in range(raters):
        turned = _turned(items, round_)
        order = sorted(asked, key=lambda i: (bits(seed, "task", round_, items[i].task), bits(seed, "item", round_, i)))
        for person in range(people):
            share = order[len(order) * person // people : len(order) * (person + 1) // people]
            made.append(tuple(_steps(items, share, turned, every, (seed, round_, person))))
    return tuple(made)


def _turned(items: Sequence[Item], round_: int) -> dict[int, int]:
    """By how many places each item's options are moved on in a round.

    The truth takes every place equally often among a task's questions of as many options, and another in every round.
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
    practice = {task: list(its) for task, its in groupby(_of(items, "practice"), key=lambda i: items[i].task)}
    checks, task = iter(_of(items, "check")), ""
    for answered, i in enumerate(share):
        if items[i].task != task:
            task = items[i].task
            yield from (Step(item=p, permutation=turned[p]) for p in practice.get(task, ()))
        if every and answered % every == bits("check", *key, answered // every) % every:
            check = next(checks)
            yield Step(item=check, permutation=bits("check", *key, check) % len(items[check].options))
        yield Step(item=i, permutation=turned[i])


def _of(items: Sequence[Item], kind: str) -> list[int]:
    return [i for i, item in enumerate(items) if item.kind == kind]
