"""Questions with drawn pictures, so that the dataset can be tested without an engine."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from wmspec.compile.design.design import Design, Instance
from wmspec.core.diagnostics import Report
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.plan import Plan, Shard, Task
from wmspec.dataset.build.rows import Row, encode
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.statements.task import check
from wmspec.runtime.questions.ask import groups
from wmspec.runtime.questions.kinds.labels import LabelAnswer
from wmspec.runtime.questions.kinds.pictures import PictureAnswer
from wmspec.runtime.questions.model import Change, Option, Picture, QuestionRow, Rejected, Vote

ENGINES = ("mujoco", "pybullet", "sapien")
TASKS = ("collide", "motion_speed")
SIDES = ("left", "right")
SPECS = Path(__file__).parent / "specs"
COLORS = {"red": "#c33", "blue": "#36c", "yellow": "#db3", "green": "#3a5", "purple": "#85b", "orange": "#e83"}


@cache
def spec(name: str) -> TaskSpec:
    report = Report()
    tasks = check(SPECS / f"{name}.wms", report)
    assert tasks, report
    return tasks[0]


def plan(count: int = 5, shard: int = 2, seed: int = 7, tasks: tuple[str, ...] = TASKS) -> Plan:
    return Plan(
        texts={f"{n}.wms": (SPECS / f"{n}.wms").read_text() for n in tasks},
        tasks=tuple(Task(spec(name), Design(spec(name), seed).sample(count)) for name in tasks),
        engines=ENGINES,
        size=(64, 64),
        seed=seed,
        consensus="all",
        rows_of="engines",
        versions={"wmspec": "0.1.0", "mujoco": "4.0", "pybullet": "3.2.7", "sapien": "3.0.3"},
        shard=shard,
    )


def question_row(task: str, index: int, engine: str, seed: int = 7, size: int = 64) -> QuestionRow:
    """The question of an instance, with a plausible picture for each look."""
    instance = Design(spec(task), seed)[index]
    ball = COLORS[str(instance.factors.get("ball_color", "red"))]
    context = tuple(Picture("front", t, picture(ball, 0.1 + 0.2 * t, engine, size)) for t in (0.0, 0.2, 0.5))
    answer = index % 4 if task == "collide" else index % 2
    options = _pictured(answer, ball, engine, size) if task == "collide" else _labelled(answer, instance)
    return QuestionRow(
        task=task,
        dimension=spec(task).dimension,
        index=index,
        block=instance.block,
        question=0,
        seed=seed,
        engine=engine,
        renderer=engine,
        text=str(spec(task).questions[0].text[0]),
        context=context,
        options=options,
        answer=answer,
        value="front at 2 s" if task == "collide" else options[answer].text or "",
        factors=instance.factors,
        nuisances=instance.nuisances,
        groups=groups(instance),
        margin=1.7 if task == "motion_speed" else None,
        measured={"contact(ball, victim)": 1.0} if task == "collide" else {"speed(left)": 0.2, "speed(right)": 0.1},
        evidence=pictures(0.0, 0.2, 0.4, 0.6)
        if task == "collide"
        else LabelAnswer(options[answer].name, ("left", "right")),
        agreement=tuple(Vote(e, answer, "said", apart=0.001) for e in ENGINES),
    )


def pictures(*places: float, names: tuple[str, ...] = (), looks: tuple[str, ...] = ()) -> PictureAnswer:
    """Where a ball is (m, along x) in the truth, which comes first, and in the counterfactuals."""
    return PictureAnswer(
        camera="front",
        time=2.0,
        names=names or ("truth", *(f"other_{i}" for i in range(1, len(places)))),
        bodies=("ball",),
        outcomes=np.array([[[x, 0, 0, 1, 0, 0, 0]] for x in places], float),
        looks=looks or ("the same",) * len(places),
    )


def _pictured(answer: int, ball: str, engine: str, size: int) -> tuple[Option, ...]:
    changes = [
        ("weaker", Change("action", "push.speed", "0.8", "0.28")),
        ("aside", Change("action", "push.direction", "0", "0.6109")),
        ("heavier", Change("state", "victim.mass", "0.05", "0.8")),
    ]
    ends = [Picture("front", 2.0, picture(ball, 0.3 + 0.15 * i, engine, size)) for i in range(4)]
    options = [Option("counterfactual", n, picture=end, change=c) for (n, c), end in zip(changes, ends, strict=False)]
    options.insert(answer, Option("truth", "truth", picture=ends[3]))
    return tuple(options)


def _labelled(answer: int, instance: Instance) -> tuple[Option, ...]:
    texts = [f"the {instance.factors['left_color']} sphere", f"the {instance.factors['right_color']} sphere"]
    kinds = ["truth" if i == answer else "label" for i in range(2)]
    return tuple(Option(k, n, text=t) for k, n, t in zip(kinds, SIDES, texts, strict=True))  # type: ignore[arg-type]


def picture(color: str, x: float, engine: str, size: int) -> np.ndarray:
    """A ball at x (0..1) before a block; each engine has its own sky."""
    sky = {"mujoco": "#dfe6ee", "pybullet": "#e6e6e6", "sapien": "#e9e4dc"}[engine]
    image = Image.new("RGB", (size, size), sky)
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, size * 0.65, size, size), fill="#b9b2a6")
    draw.rectangle((size * 0.5, size * 0.5, size * 0.7, size * 0.75), fill="#3a5")
    draw.ellipse((size * (x - 0.1), size * 0.6, size * (x + 0.1), size * 0.8), fill=color)
    return np.asarray(image)


def filling(plan: Plan, shard: Shard, size: int = 64) -> tuple[list[Row], list[Rejected]]:
    """What is made of a shard: every fifth instance is rejected in all engines."""
    rows, rejected = [], []
    name = shard.task.spec.name
    for index in shard.indices:
        for engine in plan.engines:
            if index % 5 == 0:
                rejected.append(Rejected(name, index, 0, engine, "alike", "aside and heavier: 3.1 cm apart"))
            else:
                rows.append(encode(question_row(name, index, engine, plan.seed, size), plan.rows_of))
    return rows, rejected


def make(folder: Path, plan: Plan, size: int = 64) -> Dataset:
    """A finished dataset."""
    with Dataset.open(folder, plan) as dataset:
        for shard in dataset.pending():
            dataset.write(shard, *filling(plan, shard, size))
        dataset.finish()
    return dataset
