"""Datasets of tasks."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Literal, TypedDict, Unpack

from wmspec.api.agreement import Tasks, effort, gathered
from wmspec.api.drawing import SIDE, pixels, samples_of
from wmspec.api.loading import Tell, warn
from wmspec.api.progress import Progress, silent
from wmspec.api.task import Task
from wmspec.compile.design.design import share
from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import INSTANCES
from wmspec.core.resources import resource
from wmspec.core.wm_abench import instances
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.generate import generate as make
from wmspec.dataset.build.manifest import Summary
from wmspec.dataset.build.plan import Plan
from wmspec.dataset.build.plan import Task as PlannedTask
from wmspec.dataset.build.reuse import Before
from wmspec.runtime.engines.registry import chosen, drawing, versions
from wmspec.runtime.questions.consensus import Consensus
from wmspec.runtime.workers.cluster import ray_cluster
from wmspec.runtime.workers.pool import Effort
from wmspec.sim.scene.model import Look


class Choices(TypedDict, total=False):
    """What a dataset is to hold.

    `per_task`: how many instances of each task, drawn at random; if left out, as many as the paper has of its tasks,
    and all of others; `full`: all. `part`: only share i of n of them, (i, n). `dimensions`: only tasks of these.
    `backend`: engines, joined by commas, or "all"; `renderer`: the one that draws, if not each what it executes.
    `consensus`: keep a question if "all" engines agree on it, the "majority", or "none" need to. `seed`: what the draws
    depend on, of tasks that are given by their path. `size` (px), `look` and `samples`: as in `Drawing`. `licence`:
    that of the data, such as "CC-BY-4.0"; if left out, what the specs say, and CC-BY-4.0 if all come with wmspec.
    """

    per_task: int | None
    full: bool
    part: tuple[int, int]
    dimensions: Sequence[str]
    backend: str
    renderer: str
    consensus: Consensus
    seed: int
    size: int | tuple[int, int]
    look: Look
    samples: int | None
    licence: str


Executor = Literal["local", "ray"]

#: The licence of the data that our own specs make, if no other is chosen.
OURS = "CC-BY-4.0"


def generate(
    tasks: Tasks,
    output: str | PathLike[str],
    *,
    reuse: Iterable[str | PathLike[str]] = (),
    force: bool = False,
    workers: int | None = None,
    timeout: float = 300.0,
    executor: Executor = "local",
    address: str = "",
    progress: Progress = silent,
    tell: Tell = warn,
    **choices: Unpack[Choices],
) -> Summary:
    """Make a dataset of tasks: Parquet with pictures, a manifest and a card, in the folder `output`.

    Stopped or killed, the same call goes on with the next instance.

    Args:
        tasks: a task, the path of a spec or of a folder of them, or several.
        output: the folder.
        reuse: folders to take instances from that were made before.
        force: whether to replace a different dataset in the folder.
        workers: processes, 0 to have none; one for each core if it is left out.
        timeout: seconds that an instance may take.
        executor: "local", processes of this machine, or "ray", those of a Ray cluster. What is made is the same.
        address: of the Ray cluster, such as "auto" or "10.0.0.5:6379"; one of this machine alone if it is left out.
        progress: shows how far it has come; `wmspec.progress_bar` does.
        tell: told what is left out, and what was damaged and is made again.
        **choices: what it is to hold, see `Choices`.

    Returns:
        What was kept and what was rejected, counted.

    Raises:
        WmsError: two choices exclude each other, an engine is missing, there is no such cluster, or the folder cannot
            be used.
    """
    plan = planned(tasks, tell, **choices)
    before = Before([Path(folder) for folder in reuse], plan)
    with Dataset.open(Path(output), plan, force) as dataset:
        for notice in dataset.notices:
            tell(notice)
        pending = sum(len(shard.indices) for shard in dataset.pending())
        with (
            crew(executor, address, workers, timeout, plan) as hands,
            progress(pending, "generating") as advance,
        ):
            spent = make(dataset, hands, advance, before)
        return replace(dataset.finish(), shared=spent.shared, balance=spent.balance, crash=spent.crash)


def crew(
    executor: Executor, address: str, workers: int | None, timeout: float, plan: Plan
) -> AbstractContextManager[Effort]:
    """Who does the work of a plan. Raises WmsError if an address is given for what has none."""
    if executor == "ray":
        return ray_cluster(address, workers, timeout, plan.versions)
    if address:
        raise WmsError("`address` is that of a Ray cluster", help="give `executor` ray, too")
    return nullcontext(effort(workers, timeout, plan.engines))


def planned(tasks: Tasks, tell: Tell = warn, **choices: Unpack[Choices]) -> Plan:
    """What a dataset is to hold, before anything is made. Raises WmsError where `generate` would."""
    look, renderer, backend = choices.get("look", "parity"), choices.get("renderer", ""), choices.get("backend", "all")
    per_task, full = choices.get("per_task"), choices.get("full", False)
    if full and per_task:
        raise WmsError("`full` makes all instances and `per_task` some of them; give one of the two")
    if not -(1 << 63) <= choices.get("seed", 0) < 1 << 63:
        raise WmsError(f"a seed is a number from {-(1 << 63)} to {(1 << 63) - 1}, which a column of a dataset can hold")
    chosen_tasks = gathered(tasks, choices.get("seed"), tell, choices.get("dimensions", ()))
    engines = chosen(backend) if renderer else drawing(chosen(backend), look)
    drawers = drawing(chosen(renderer), look) if renderer else engines
    if renderer and len(drawers) > 1:
        raise WmsError("one engine draws; name it as `renderer`, or leave it out so that each draws for itself")
    for task in chosen_tasks:
        if not task.questions:
            raise WmsError(f"the task `{task.name}` has no question, so there is nothing to generate")
    return Plan(
        texts=texts(chosen_tasks),
        tasks=tuple(PlannedTask(t.spec, indices(t, per_task, full, choices.get("part", (1, 1)))) for t in chosen_tasks),
        engines=engines,
        size=pixels(choices.get("size", SIDE)),
        seed=chosen_tasks[0].seed,
        consensus=choices.get("consensus", "all"),
        look=look,
        samples=samples_of(look, choices.get("samples")),
        renderer=drawers[0] if renderer else "",
        licence=_licence(chosen_tasks, choices.get("licence", "")),
        versions=versions({*engines, *drawers}, look),
    )


def _licence(tasks: Sequence[Task], chosen: str) -> str:
    """The licence of the data; empty if each spec says its own. Raises WmsError if it is no name of one."""
    if chosen and not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.+-]{0,60}", chosen):
        raise WmsError(
            f"`{chosen}` is no name of a licence", help="give its SPDX identifier, such as CC-BY-4.0 or CC0-1.0"
        )
    ours = resource("specs").resolve()
    return chosen or (OURS if all(t.path and t.path.resolve().is_relative_to(ours) for t in tasks) else "")


def texts(tasks: Sequence[Task]) -> dict[str, str]:
    """The specs and what they use, by file name, with as much of the path as tells two files apart."""
    programs = {task.path.resolve() if task.path else Path(task.file): task.program for task in tasks}
    read: dict[str, str] = {}
    for path in sorted(programs):
        program = programs[path]
        parts = next(n for n in range(1, 99) if [p.parts[-n:] for p in programs].count(path.parts[-n:]) == 1)
        read["/".join(path.parts[-parts:])] = program.source.text
        read |= {file.span.source.name: file.span.source.text for file in program.libraries.values()}
    return read


def indices(task: Task, per_task: int | None, full: bool, part: tuple[int, int]) -> tuple[int, ...]:
    """The instances to make: all, or a sample as large as asked for or as the paper's, and of these a share."""
    count = len(task) if full else per_task or instances(task.name, task.questions)
    if min(count or len(task), len(task)) > INSTANCES.most:
        raise WmsError(f"`{task.name}` {INSTANCES.sentence}", help=INSTANCES.help)
    chosen = range(len(task)) if count is None or count >= len(task) else sorted(task.design.sample(count))
    try:
        return tuple(chosen[share(len(chosen), *part)])
    except IndexError as error:
        raise WmsError(f"part {part}: {error}") from None
