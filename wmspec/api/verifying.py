"""Recompute a dataset, or a sample of it, and compare."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from dataclasses import replace
from os import PathLike
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Any

from wmspec.api.agreement import collect_tasks, worker_settings
from wmspec.api.loading import Tell, warn
from wmspec.api.profile import check_profile, with_profile
from wmspec.api.progress import Progress, silent
from wmspec.api.task import Task
from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import is_file_name
from wmspec.dataset.build import files
from wmspec.dataset.build.derived import publication_date
from wmspec.dataset.build.plan import FORMAT, Plan
from wmspec.dataset.build.plan import Task as PlannedTask
from wmspec.dataset.build.reader import DatasetReader, read_plan
from wmspec.dataset.build.splits import Split
from wmspec.dataset.verify.folder import folder_differences
from wmspec.dataset.verify.model import Verification
from wmspec.dataset.verify.records import check_records
from wmspec.dataset.verify.specs import spec_differences
from wmspec.dataset.verify.verify import draw_sample, regenerate, strict
from wmspec.lang.parse.files import BUNDLED
from wmspec.runtime.engines.registry import quickest_renderer, require_look, select_backends, versions


def verify(
    folder: str | PathLike[str],
    *,
    sample: int | None = None,
    every: bool = False,
    sample_seed: int | None = None,
    other_machine: bool = False,
    workers: int | None = None,
    timeout: float = 300.0,
    progress: Progress = silent,
    tell: Tell = warn,
) -> Verification:
    """Recompute a dataset from the specs and seed in its manifest and compare.

    Ids, order, counts, factors and the place of the answer are checked in every row, and every file of the folder. A
    random sample of rows and of rejected questions is generated again.

    Args:
        folder: the dataset.
        sample: number of rows, and of rejected questions, to draw; by default as many as detect with 99 % probability
            that 5 % of the rows changed. At least one row of each task is drawn, and whole groups of closed sets.
        every: generate all questions again.
        sample_seed: draws the sample of an earlier verification again; by default a new one.
        other_machine: accept small differences of numbers and pictures although the versions are the same, since the
            dataset was made with other graphics drivers or another processor.
        workers: number of processes; 0 runs in this one. One per core by default.
        timeout: time limit per instance, in seconds.
        progress: shows the progress.
        tell: receives warnings of the specs.

    Raises:
        WmsError: the dataset is unfinished or damaged, has another format, or its specs cannot be read.
    """
    dataset = DatasetReader.open(Path(folder))
    dataset.intact()
    _check_format(dataset)
    with TemporaryDirectory() as scratch:
        tasks = collect_tasks(write_specs(dataset, Path(scratch)), dataset.manifest["seed"], tell)
    tasks = with_profile(tasks, check_profile(dataset.manifest.get("profile", "")))
    known = {task.name: task for task in tasks}
    if unknown := [name for name in dataset.tasks if name not in known]:
        raise WmsError(f"the specs in {dataset.folder / files.MANIFEST} have no task `{unknown[0]}`")
    plan = _plan(dataset, [known[name] for name in dataset.tasks])
    records = check_records(dataset, plan)
    differences = [*spec_differences(dataset), *records.differences, *folder_differences(dataset, plan, records.shards)]
    seed = secrets.randbits(63) if sample_seed is None else sample_seed
    drawn = draw_sample(plan, records, sample, every, seed)
    chosen = replace(plan, tasks=drawn.tasks)
    with progress(drawn.size, "verifying") as advance:
        settings = worker_settings(workers, timeout, plan.engines)
        questions, found = regenerate(dataset, chosen, records, settings, advance)
    there, here = plan.versions, _installed_versions(plan)
    others = {name: (there.get(name, "none"), v) for name, v in here.items() if there.get(name) != v}
    exact = not others and not other_machine
    differences += found
    return Verification(
        questions=questions,
        planned=sum(len(task.indices) * len(task.spec.questions) for task in plan.tasks) * len(plan.row_engines),
        differences=tuple(strict(differences) if exact else differences),
        versions=others,
        power=drawn.power,
        limits=tuple(_limits(dataset, plan)),
        sample_seed=seed,
    )


def _limits(dataset: DatasetReader, plan: Plan) -> Iterator[str]:
    """Yield what no verification can find, as sentences."""
    licence = f"its licence ({plan.licence}), " if plan.licence else ""
    date = publication_date(dataset.folder) or "none"
    yield (
        f"the dataset itself states its seed ({plan.seed}), {licence}date ({date}) and which tasks it has; edits of "
        "its own specs that change no row, such as comments, make another valid dataset; a seal shows such changes "
        "(wmspec attest)"
    )
    if plan.split is not None:
        yield f"it is the split `{plan.split.name}` of its instances"
    if plan.part != (1, 1):
        yield f"it is share {plan.part[0]} of {plan.part[1]} of its instances"


def _check_format(dataset: DatasetReader) -> None:
    """Raise WmsError if another version ordered the instances and named the questions in its own way."""
    there, made_by = dataset.manifest.get("format"), dataset.manifest["versions"].get("wmspec", "")
    if there != FORMAT and dataset.manifest.get("specs"):
        raise WmsError(
            f"{dataset.folder} has format {there}; this version makes format {FORMAT}, in which the order of instances "
            "and the ids differ, so that the same question cannot be made again",
            help=f"verify it with the version that made it{f': pip install wmspec=={made_by}' if made_by else ''}",
        )


def write_specs(dataset: DatasetReader, scratch: Path) -> list[Path]:
    """Write the specs of a manifest to files, each in a folder with all libraries; return their paths.

    Bundled libraries come from the manifest too, as files beside the spec.
    """
    texts = {
        PurePosixPath(name.removeprefix(BUNDLED)): spec["text"] for name, spec in dataset.manifest["specs"].items()
    }
    for name in texts:
        if not is_file_name(name.name.removesuffix(".wms")):
            raise WmsError(f"{dataset.folder / files.MANIFEST} has a spec of the name {str(name)[:80]!r}")
    paths = []
    for number, name in enumerate(n for n in dataset.manifest["specs"] if not n.startswith(BUNDLED)):
        own = PurePosixPath(name)
        place = scratch / str(number)
        place.mkdir()
        for other in sorted(texts, key=lambda other: (other == own, other.parent == own.parent)):  # the last one stays
            (place / other.name).write_text(texts[other], encoding="utf-8")
        paths.append(place / own.name)
    return paths


def _plan(dataset: DatasetReader, tasks: list[Task]) -> Plan:
    """Return the plan of the dataset, from its specs and settings."""
    manifest = dataset.manifest
    indices = read_plan(dataset.folder).get("tasks", {})
    part: list[int] = manifest.get("part", [1, 1])
    planned = (
        PlannedTask(task.spec, tuple(_indices(dataset, task, indices)), manifest["tasks"][task.name].get("selected"))
        for task in tasks
    )
    return Plan(
        texts={name: spec["text"] for name, spec in manifest["specs"].items()},
        tasks=tuple(planned),
        engines=select_backends(",".join(manifest["engines"])),
        size=(manifest["size"][0], manifest["size"][1]),
        seed=manifest["seed"],
        consensus=manifest["consensus"],
        rows_of=dataset.rows_of,
        profile=manifest.get("profile", ""),
        part=(part[0], part[1]),
        shard=manifest["shard"],
        licence=manifest.get("licence", ""),
        versions=manifest["versions"],
        film=dataset.film,
        split=Split.of(manifest.get("split")),
        **render_settings(dataset),
    )


def _installed_versions(plan: Plan) -> dict[str, str]:
    """Return the installed versions of what the plan needs. Raises WmsError if an engine cannot draw."""
    drawers = require_look([plan.renderer] if plan.renderer else plan.engines, plan.look)
    return versions({*plan.engines, *drawers}, plan.look)


def render_settings(dataset: DatasetReader) -> dict[str, Any]:
    """Return the look, samples and renderer of a dataset; the defaults if it has no plan file.

    Raises WmsError if an engine is not known here.
    """
    plan = read_plan(dataset.folder)
    default = quickest_renderer(dataset.engines) if dataset.rows_of == "questions" and "renderer" not in plan else ""
    defaults = {"look": "parity", "samples": None, "renderer": default}
    return {name: plan.get(name, value) for name, value in defaults.items()}


def _indices(dataset: DatasetReader, task: Task, planned: dict[str, Any]) -> list[int]:
    """Return the instances of a task: of the plan file, or if that has none, of rows and rejections."""
    if isinstance(there := planned.get(task.name), list) and all(isinstance(i, int) for i in there):
        return there
    indices = {row["index"] for row in dataset.rows(task.name, ["id", "task", "index", "engine"])}
    indices |= {r["index"] for r in dataset.manifest["rejected"]["list"] if r["task"] == task.name}
    return sorted(indices)
