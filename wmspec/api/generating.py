"""Generate datasets."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Literal, TypedDict, Unpack, get_args

from wmspec.api.agreement import Tasks, collect_tasks, worker_settings
from wmspec.api.loading import Tell, warn
from wmspec.api.profile import Profile, check_profile, with_profile
from wmspec.api.progress import Progress, silent
from wmspec.api.rendering import DEFAULT_SIDE, check_samples, pixels
from wmspec.api.task import Task
from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import INSTANCES
from wmspec.core.places import Source
from wmspec.core.resources import resource
from wmspec.core.wm_abench import instance_count
from wmspec.dataset.build.answer_counts import balance_shifts
from wmspec.dataset.build.dataset import Dataset
from wmspec.dataset.build.generate import generate as make
from wmspec.dataset.build.manifest import Summary
from wmspec.dataset.build.plan import Plan
from wmspec.dataset.build.plan import Task as PlannedTask
from wmspec.dataset.build.reuse import PriorInstances
from wmspec.dataset.build.splits import Split, parse_split
from wmspec.dataset.film.codec import pyav
from wmspec.dataset.film.group import has_film
from wmspec.dataset.film.timing import DEFAULT_SIZE as DEFAULT_FILM_SIZE
from wmspec.dataset.film.timing import FilmSettings
from wmspec.lang.parse.files import BUNDLED
from wmspec.runtime.engines.registry import quickest_renderer, require_look, select_backends, versions
from wmspec.runtime.questions.consensus import Consensus, RowsOf
from wmspec.runtime.workers.cluster import ray_cluster
from wmspec.runtime.workers.pool import PoolConfig
from wmspec.sim.scene.model import Look


class DatasetOptions(TypedDict, total=False):
    """The content of a dataset.

    `per_task`: number of random instances per task, by default that of WM-ABench for its tasks and all instances
    for others; `full`: all instances. `profile`: "wm-abench" for the paper's tasks in the paper's form. `part`: (i, n),
    only share i of n. `dimensions`: only tasks of these dimensions. `backend`: engines, separated by commas, or "all";
    the first is the reference, whose episode is shown. `rows`: "questions" for one row per question, answered in
    all engines, or "engines" for one row per question and engine. `renderer`: one engine that draws all episodes, by
    default the quickest; with "engines", each draws its own by default. `consensus`: keep a question if "all"
    engines agree, if the "majority" agrees, or always ("none"). `seed`: random seed of tasks given by path. `size`
    (pixels), `look` and `samples`: see `RenderOptions`. `film`: frames per second of films of closed sets, None for no
    films; `film_size`: their width and height (pixels); `film_for`: the least time (s) that they continue after the
    context. `licence`: SPDX identifier of the data licence, by default that of the specs, and CC-BY-4.0 for specs of
    wmspec. `split`: only the instances of "train", "validation" or "test"; the first two without the hold-outs of the
    specs. `shares`: percent of each split, such as "train=80,validation=10,test=10".
    """

    per_task: int | None
    full: bool
    profile: Profile
    part: tuple[int, int]
    dimensions: Sequence[str]
    backend: str
    rows: RowsOf
    renderer: str
    consensus: Consensus
    seed: int
    size: int | tuple[int, int]
    look: Look
    samples: int | None
    film: int | None
    film_size: tuple[int, int]
    film_for: float
    licence: str
    split: str
    shares: str


Executor = Literal["local", "ray"]

#: The default licence of data from the specs of wmspec.
DEFAULT_LICENCE = "CC-BY-4.0"


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
    **options: Unpack[DatasetOptions],
) -> Summary:
    """Generate a dataset of tasks into the folder `output`: Parquet with pictures, a manifest and a card.

    The same call resumes an interrupted run.

    Args:
        tasks: a task, the path of a spec or of a folder of specs, or several of these.
        output: the dataset folder.
        reuse: folders of earlier datasets whose instances are reused.
        force: whether to replace a different dataset in the folder.
        workers: number of processes; 0 runs in this one. One per core by default.
        timeout: time limit per instance, in seconds.
        executor: "local" processes or a "ray" cluster. The dataset is the same.
        address: of the Ray cluster, such as "auto" or "10.0.0.5:6379"; this machine only by default.
        progress: shows the progress, such as `wmspec.progress_bar`.
        tell: receives warnings. They include damaged files that are generated again, groups with more instances than
            `per_task`, and questions whose gates unbalance the answers.
        **options: see `DatasetOptions`.

    Returns:
        The numbers of kept and rejected questions.

    Raises:
        WmsError: two options exclude each other, an engine is missing, the cluster is not reachable, or the folder
            cannot be used.
    """
    plan = plan_dataset(tasks, tell, **options)
    for notice in _larger_samples(plan, options.get("per_task")):
        tell(notice)
    before = PriorInstances([Path(folder) for folder in reuse], plan)
    with Dataset.open(Path(output), plan, force) as dataset:
        for notice in dataset.notices:
            tell(notice)
        pending = sum(len(shard.indices) for shard in dataset.pending())
        with (
            open_workers(executor, address, workers, timeout, plan) as pool,
            progress(pending, "generating") as advance,
        ):
            spent = make(dataset, pool, advance, before)
        summary = dataset.finish()
        for warning in balance_shifts(Path(output), plan):
            tell(warning)
        return replace(summary, shared=spent.shared, balance=spent.balance, crash=spent.crash)


def open_workers(
    executor: Executor, address: str, workers: int | None, timeout: float, plan: Plan
) -> AbstractContextManager[PoolConfig]:
    """Return the workers of a plan, as a context. Raises WmsError for an address without Ray."""
    if executor == "ray":
        return ray_cluster(address, workers, timeout, plan.versions)
    if address:
        raise WmsError("`address` is for Ray clusters", help="set `executor` to ray too")
    return nullcontext(worker_settings(workers, timeout, plan.engines))


def plan_dataset(tasks: Tasks, tell: Tell = warn, **options: Unpack[DatasetOptions]) -> Plan:
    """Return the plan of a dataset, before anything is generated. Raises WmsError where `generate` would."""
    look, renderer, backend = options.get("look", "parity"), options.get("renderer", ""), options.get("backend", "all")
    per_task, full, part = options.get("per_task"), options.get("full", False), options.get("part", (1, 1))
    if full and per_task:
        raise WmsError("`full` and `per_task` exclude each other; give one of the two")
    if not -(1 << 63) <= options.get("seed", 0) < 1 << 63:
        raise WmsError(f"a seed is an integer from {-(1 << 63)} to {(1 << 63) - 1}")
    profile = check_profile(options.get("profile", ""))
    chosen_tasks = with_profile(collect_tasks(tasks, options.get("seed"), tell, options.get("dimensions", ())), profile)
    engines, rows_of = select_backends(backend), options.get("rows", "questions")
    if rows_of not in get_args(RowsOf):
        raise WmsError(f"no rows of {rows_of!r}", help=f"rows are of {' or of '.join(get_args(RowsOf))}")
    if rows_of == "questions":
        renderer = renderer or quickest_renderer(engines)
    split = parse_split(options.get("split", ""), options.get("shares", ""))
    drawers = require_look(select_backends(renderer) if renderer else engines, look)
    if renderer and len(drawers) > 1:
        raise WmsError("`renderer` expects one engine")
    for task in chosen_tasks:
        if not task.questions:
            raise WmsError(f"the task `{task.name}` has no question; nothing to generate")
    return Plan(
        texts=spec_texts(chosen_tasks),
        tasks=tuple(planned_task(t, per_task, full, part, split) for t in chosen_tasks),
        engines=engines,
        size=pixels(options.get("size", DEFAULT_SIDE)),
        seed=chosen_tasks[0].seed,
        consensus=options.get("consensus", "all"),
        look=look,
        samples=check_samples(look, options.get("samples")),
        renderer=drawers[0] if renderer else "",
        rows_of=rows_of,
        profile=profile,
        part=part,
        film=_film(options, chosen_tasks, look),
        licence=_licence(chosen_tasks, options.get("licence", "")),
        split=split,
        versions=versions({*engines, *drawers}, look),
    )


def _larger_samples(plan: Plan, requested: int | None) -> Iterator[str]:
    """Yield a notice for each task of which control groups require more instances than requested."""
    for task in plan.tasks:
        if requested and task.selected and task.selected > requested:
            yield f"`{task.spec.name}`: {task.selected} instances instead of {requested}, as control groups are whole"


def _film(options: DatasetOptions, tasks: Sequence[Task], look: Look) -> FilmSettings | None:
    """Return the settings of films. Raises WmsError if no task has films, or if they cannot be made."""
    rate, size, seconds = options.get("film"), options.get("film_size"), options.get("film_for")
    if rate is None:
        if size is not None or seconds is not None:
            name = "film_size" if size is not None else "film_for"
            raise WmsError(f"`{name}` is a setting of films", help="set `film` too, such as 24 frames per second")
        return None
    if look != "parity":
        raise WmsError(f"films are drawn in the look `parity`, and the pictures in `{look}`", help="remove one of them")
    if not any(has_film(task.spec, question) for task in tasks for question in task.spec.questions):
        message = "no task has a question with a closed set of pictures (`options orbit of ...`), so no films"
        raise WmsError(message, help="or `film CAMERA` in a task with `answer possible`")
    pyav()
    return FilmSettings(rate, pixels(size or DEFAULT_FILM_SIZE), seconds)


def _licence(tasks: Sequence[Task], chosen: str) -> str:
    """Return the data licence; empty if each spec states its own. Raises WmsError if it is no SPDX identifier."""
    if chosen and not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.+-]{0,60}", chosen):
        raise WmsError(
            f"`{chosen}` is not a licence identifier",
            help="give its SPDX identifier, such as CC-BY-4.0 or CC0-1.0",
        )
    ours = resource("specs").resolve()
    return chosen or (DEFAULT_LICENCE if all(t.path and t.path.resolve().is_relative_to(ours) for t in tasks) else "")


def spec_texts(tasks: Sequence[Task]) -> dict[str, str]:
    """Return the specs and their libraries by file name, with as much of the path as is needed to be unique.

    Libraries of wmspec are named `<library>/NAME.wms`.
    """
    sources: dict[Path, Source] = {}
    bundled: dict[str, str] = {}
    for task in tasks:
        sources[task.path.resolve() if task.path else Path(task.file)] = task.source
        for path, library in task.libraries.items():
            if library.name.startswith(BUNDLED):
                bundled[library.name] = library.text
            else:
                sources[path.resolve()] = library
    texts = dict(bundled)
    for path in sorted(sources):
        parts = next(n for n in range(1, 999) if [p.parts[-n:] for p in sources].count(path.parts[-n:]) == 1)
        texts["/".join(path.parts[-parts:])] = sources[path].text
    return texts


def planned_task(
    task: Task, per_task: int | None, full: bool, part: tuple[int, int], split: Split | None = None
) -> PlannedTask:
    """Return a task with its instances: all, or a sample of the requested or the paper's size; of these a share.

    With a split, these are instances of the split. Raises WmsError if it has none.
    """
    count = len(task) if full else per_task or instance_count(task.name, task.questions)
    if min(count or len(task), len(task)) > INSTANCES.most:
        raise WmsError(f"`{task.name}` {INSTANCES.sentence}", help=INSTANCES.help)
    try:
        allowed = split.contains(task.design) if split else None
        selected = task.design.selection(count, allowed=allowed)
        if split and not selected:
            raise split.nothing_left(task.design)
        return PlannedTask(task.spec, task.design.selection(count, *part, allowed), len(selected))
    except IndexError as error:
        raise WmsError(f"part {part}: {error}") from None
