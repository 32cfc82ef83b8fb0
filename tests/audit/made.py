"""Datasets with drawn pictures whose answers can be had in the ways that a test wants, and in no others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.dataset.made import pictures
from wmspec.compile.design.design import Design
from wmspec.core.diagnostics import Report
from wmspec.core.rng import Permutation
from wmspec.dataset.audit import power, probe_selection
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.plan import Plan, Task
from wmspec.dataset.build.rows import encode
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.statements.task import check
from wmspec.runtime.questions.ask import groups, names_of
from wmspec.runtime.questions.kinds.labels import LabelAnswer
from wmspec.runtime.questions.kinds.numbers import NumberAnswer
from wmspec.runtime.questions.model import Change, Option, Picture, QuestionRow, VisibleObject

SIDE = 48
SPECS = Path(__file__).parent / "specs"
TONES = {"red": (200, 50, 50), "green": (50, 160, 80), "blue": (50, 90, 200), "yellow": (220, 190, 50)}

Ask = Callable[[QuestionRow, np.random.Generator], QuestionRow]


@cache
def spec(name: str) -> TaskSpec:
    report = Report()
    tasks = check(SPECS / f"{name}.wms", report)
    assert tasks, report
    return tasks[0]


def inject_rarely(patch: pytest.MonkeyPatch) -> None:
    """Let an audit inject few shortcuts to learn which ones it would detect; that takes most of its time."""
    patch.setattr(probe_selection, "INJECTIONS", 2)
    patch.setattr(power, "INJECTIONS", {"linear": 2, "forest": 2})


def make(
    folder: Path, name: str, ask: Ask, count: int = 400, engines: tuple[str, ...] = ("mujoco",), seed: int = 3
) -> Path:
    """A finished dataset of `count` instances of a task, asked by `ask` from a blank question."""
    return make_all(folder, {name: ask}, count, engines, seed)


def make_all(
    folder: Path, asks: Mapping[str, Ask], count: int, engines: tuple[str, ...] = ("mujoco",), seed: int = 3
) -> Path:
    """The same of several tasks."""
    designs = {name: Design(spec(name), seed) for name in asks}
    plan = Plan(
        texts={f"{name}.wms": (SPECS / f"{name}.wms").read_text() for name in asks},
        tasks=tuple(  # of groups of up to 8
            Task(design.spec, tuple(sorted(design.sample(count + 8)[:count]))) for design in designs.values()
        ),
        engines=engines,
        size=(SIDE, SIDE),
        seed=seed,
        consensus="all",
        rows_of="engines",
        versions={"wmspec": "0.1.0"},
    )
    with Dataset.open(folder, plan, force=True) as dataset:
        for shard in dataset.pending():
            name = next(name for name, design in designs.items() if design.spec.name == shard.task.spec.name)
            order = shuffled(designs[name], shard.task.indices)
            every = [(i, blank(designs[name], order[i], e)) for i in shard.indices for e in engines]
            rows = [
                encode(replace(asks[name](question, np.random.default_rng(question.index)), index=i), "engines")
                for i, question in every
            ]
            dataset.write(shard, rows, ())
        dataset.finish()
    return folder


def shuffled(design: Design, indices: Sequence[int]) -> dict[int, int]:
    """The instance behind each index: another of its group, at random, so that an index tells no level."""
    blocks: dict[int, list[int]] = {}
    for index in indices:
        blocks.setdefault(design[index].block, []).append(index)
    random = np.random.default_rng(design.seed)
    return {i: int(j) for those in blocks.values() for i, j in zip(those, random.permutation(those), strict=True)}


def blank(design: Design, index: int, engine: str) -> QuestionRow:
    instance = design[index]
    return QuestionRow(
        task=design.spec.name,
        dimension=design.spec.dimension,
        index=index,
        block=instance.block,
        question=0,
        seed=design.seed,
        engine=engine,
        renderer=engine,
        text="",
        context=(),
        options=(),
        answer=0,
        value="",
        factors=instance.factors,
        nuisances=instance.nuisances,
        groups=groups(instance),
        margin=None,
        measured={},
        evidence=NumberAnswer(0.0, 0.5),
        moments=2,
        levels=names_of(design.spec, instance.values),
    )


def race(favoured: float = 0.5, level: bool = False, telling: bool = False) -> Ask:
    """Which of two balls is faster? They go in a circle from anywhere; from the same place if they start `level`.

    The first option is true with the share `favoured`. If `telling`, the true option is the longer text.
    """

    def ask(source: QuestionRow, random: np.random.Generator) -> QuestionRow:
        truth, place = str(source.factors["faster"]), int(asking_order(source, 320) >= favoured)
        far = {b: 0.15 * float(str(source.factors["ratio"])) if b == truth else 0.15 for b in ROWS}
        starts = {b: 0.15 if level else random.random() for b in ROWS}
        tones = {"upper": TONES[str(source.factors["tone"])], "lower": (20, 20, 20)}
        views = ([(starts[b] + late * far[b], y, tones[b]) for b, y in ROWS.items()] for late in (0, 1))
        order = [truth, other(truth)] if place == 0 else [other(truth), truth]
        texts = {b: f"the {b} ball{', surely' * (telling and b == truth)}" for b in ROWS}
        return replace(
            source,
            text="Which ball is faster?",
            context=tuple(Picture("front", 2.0 * late, picture(balls)) for late, balls in enumerate(views)),
            options=tuple(Option("truth" if b == truth else "label", b, text=texts[b]) for b in order),
            answer=place,
            value=truth,
            evidence=LabelAnswer(truth, tuple(order)),
        )

    return ask


def asking_order(source: QuestionRow, count: int) -> float:
    """A share from 0 to 1, evenly spread over the design, as wmspec spreads the places of true options."""
    return Permutation(count, "place")(source.index) / count


ROWS = {"upper": 0.3, "lower": 0.7}


def other(ball: str) -> str:
    return "lower" if ball == "upper" else "upper"


def roll(betrayed: str = "", alike: bool = False) -> Ask:
    """Where does a ball roll that goes in a circle by the same step twice? All options are anywhere, unless the truth
    is `betrayed`: by its colour, or because it lies in the middle. If `alike`, two of them are the same.
    """

    def ask(source: QuestionRow, random: np.random.Generator) -> QuestionRow:
        tone, place = TONES[str(source.factors["tone"])], int(4 * asking_order(source, 336))
        ends = _apart(random)
        if betrayed == "middle":  # each of the others differs from it in one thing
            x = ends[0][0]
            ends = [(x - 0.08, 0.5), (x + 0.08, 0.5), (x, 0.58)]
            ends.insert(place, (x, 0.5))
        if alike:
            ends[place - 1] = ends[place - 2]
        step = random.random()
        context = ((0.0, ends[place][0] - 2 * step), (0.5, ends[place][0] - step))
        paler = tuple(min(255, c + 40) for c in tone) if betrayed == "colour" else tone
        names = ["slower", "faster", "aside"]
        names.insert(place, "truth")
        options = tuple(
            option(n, picture([(*end, paler if n == "truth" else tone)])) for n, end in zip(names, ends, strict=True)
        )
        shown = tuple(Picture("front", t, picture([(x, 0.5, tone)])) for t, x in context)
        return replace(
            source,
            text="Where next?",
            context=shown,
            options=options,
            answer=place,
            value="front at 1 s",
            evidence=pictures(0.0, 0.1, 0.2, 0.3),
        )

    return ask


def _apart(random: np.random.Generator) -> list[tuple[float, float]]:
    """Four places (x, y) on the circle, none close to another."""
    found: list[float] = []
    while len(found) < 4:
        place = random.random()
        if all(abs((place - other + 0.5) % 1 - 0.5) > 0.1 for other in found):
            found.append(place)
    return [(place, 0.5) for place in found]


def option(name: str, rgb: Any) -> Option:
    kind, change = ("truth", None) if name == "truth" else ("counterfactual", Change("action", "push.speed", "1", "2"))
    return Option(kind, name, picture=Picture("front", 1.0, rgb), change=change)  # type: ignore[arg-type]


def picture(balls: Sequence[tuple[float, float, tuple[int, ...]]]) -> np.ndarray:
    """Balls (x, y, colour) on a pale ground, smooth at their edges; what leaves at the right comes in at the left."""
    y, x = np.mgrid[0:SIDE, 0:SIDE] / SIDE
    image = np.full((SIDE, SIDE, 3), 225.0)
    for u, v, color in balls:
        aside = (x - u + 0.5) % 1 - 0.5
        cover = np.clip((0.08 - np.hypot(aside, y - v)) * SIDE + 0.5, 0, 1)[..., None]
        image = image * (1 - cover) + np.array(color) * cover
    return image.round().astype(np.uint8)


#: Where a ball comes to rest, by weight and way: on the circle, each way mirrors the other.
ENDS = {("light", "left"): 0.1, ("heavy", "left"): 0.3, ("heavy", "right"): 0.7, ("light", "right"): 0.9}


def slide(revealing: bool = False, in_words: bool = True) -> Ask:
    """Where does a ball come to rest? It starts anywhere on the circle and moves by one step.

    If `revealing`, it starts in the middle and its step ends near the rest of a heavy ball that goes the same way. Then
    the nearest option shows the way. The weight is in the text if it is `in_words`.
    """

    def ask(source: QuestionRow, random: np.random.Generator) -> QuestionRow:
        weight, way = source.levels["weight"], source.levels["way"]
        tone, sign = TONES[str(source.factors["tone"])], 1 if way == "right" else -1
        middle = 0.5 if revealing else random.random()
        seen = (middle, middle + sign * 0.17) if revealing else (middle - sign * 0.05, middle + sign * 0.05)
        order = list(ENDS)
        random.shuffle(order)
        options = tuple(_closed(each, (weight, way), tone) for each in order)
        return replace(
            source,
            text=f"The ball is {weight}. Where does it come to rest?" if in_words else "Where does it come to rest?",
            context=tuple(Picture("front", 0.1 * i, picture([(x, 0.5, tone)])) for i, x in enumerate(seen)),
            objects=tuple((_ball(x),) for x in seen),
            options=options,
            answer=order.index((weight, way)),
            value="front at 1 s",
            crossed=("weight", "way"),
            evidence=pictures(0.0, 0.1, 0.2, 0.3),
        )

    return ask


def _closed(end: tuple[str, str], truth: tuple[str, str], tone: tuple[int, ...]) -> Option:
    """The option of a closed set, with what differs from the truth."""
    differs = [
        Change(kind, name, true, mine)
        for kind, name, true, mine in zip(("state", "action"), ("weight", "way"), truth, end, strict=True)
        if mine != true
    ]
    change = replace(differs[0], beside=differs[1]) if len(differs) == 2 else differs[0] if differs else None
    kind: Any = "truth" if not differs else "both" if len(differs) == 2 else differs[0].kind
    name, seen = "_".join(end) if differs else "truth", (_ball(ENDS[end]),)
    return Option(
        kind, name, picture=Picture("front", 1.0, picture([(ENDS[end], 0.5, tone)])), change=change, objects=seen
    )


def _ball(x: float) -> VisibleObject:
    return VisibleObject(
        "ball", ("ball",), True, (x, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), 0.02, x % 1, 0.5, (0.5, 0.5, 0.5)
    )
