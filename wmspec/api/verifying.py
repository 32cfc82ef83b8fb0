"""Regenerate part of a dataset and compare."""

from __future__ import annotations

from os import PathLike
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import NamedTuple

from wmspec.api.agreement import collect_tasks, worker_settings
from wmspec.api.loading import Tell, warn
from wmspec.api.profile import check_profile, with_profile
from wmspec.api.progress import Progress, silent
from wmspec.api.task import Task
from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import is_file_name
from wmspec.dataset.build import files
from wmspec.dataset.build.plan import FORMAT, Plan
from wmspec.dataset.build.plan import Task as PlannedTask
from wmspec.dataset.build.reader import DatasetReader, read_plan
from wmspec.dataset.verify import Verification
from wmspec.dataset.verify import verify as compare
from wmspec.runtime.engines.registry import require_look, select_backends, versions
from wmspec.sim.scene.model import Look

LIBRARY = "<library>/"


def verify(
    folder: str | PathLike[str],
    *,
    sample: int | None = 4,
    workers: int | None = None,
    timeout: float = 300.0,
    progress: Progress = silent,
    tell: Tell = warn,
) -> Verification:
    """Regenerate instances of a dataset from the specs in its manifest and compare them with its rows.

    Args:
        folder: the dataset.
        sample: number of instances per task, spread evenly (whole groups of closed sets); None for all.
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
    plan = _plan(dataset, [known[name] for name in dataset.tasks], sample)
    with progress(sum(len(task.indices) for task in plan.tasks), "verifying") as advance:
        return compare(dataset, plan, worker_settings(workers, timeout, plan.engines), advance)


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
    """Write the specs of a manifest to files, each in a folder with all libraries; return their paths."""
    texts = {name: spec["text"] for name, spec in dataset.manifest["specs"].items()}
    tasks = {name: text for name, text in texts.items() if not name.startswith(LIBRARY)}
    libraries = {name.removeprefix(LIBRARY): text for name, text in texts.items() if name.startswith(LIBRARY)}
    paths = []
    for number, (name, text) in enumerate(tasks.items()):
        place = scratch / str(number)
        place.mkdir()
        for file, content in {**libraries, PurePosixPath(name).name: text}.items():
            if not is_file_name(file.removesuffix(".wms")):
                raise WmsError(f"{dataset.folder / files.MANIFEST} has a spec of the name {file[:80]!r}")
            (place / file).write_text(content, encoding="utf-8")
        paths.append(place / PurePosixPath(name).name)
    return paths


def _plan(dataset: DatasetReader, tasks: list[Task], sample: int | None) -> Plan:
    """Return the plan of the dataset, restricted to a sample of its instances."""
    manifest, plan = dataset.manifest, render_settings(dataset)
    engines = select_backends(",".join(manifest["engines"]))
    drawers = require_look([plan.renderer] if plan.renderer else engines, plan.look)
    return Plan(
        texts={},
        tasks=tuple(PlannedTask(task.spec, _spread(_indices(dataset, task), sample)) for task in tasks),
        engines=engines,
        size=(manifest["size"][0], manifest["size"][1]),
        seed=manifest["seed"],
        consensus=manifest["consensus"],
        look=plan.look,
        samples=plan.samples,
        renderer=plan.renderer,
        rows_of=dataset.rows_of,
        profile=dataset.manifest.get("profile", ""),
        versions=versions({*engines, *drawers}, plan.look),
    )


class RenderSettings(NamedTuple):
    """The render settings of a dataset."""

    look: Look
    samples: int | None
    renderer: str


def render_settings(dataset: DatasetReader) -> RenderSettings:
    """Return the render settings of a dataset; the defaults if it has no plan file."""
    plan = read_plan(dataset.folder)
    return RenderSettings(plan.get("look", "parity"), plan.get("samples"), plan.get("renderer", ""))


def _indices(dataset: DatasetReader, task: Task) -> list[int]:
    indices = {row["index"] for row in dataset.rows(task.name, ["id", "task", "index", "engine"])}
    indices |= {r["index"] for r in dataset.manifest["rejected"]["list"] if r["task"] == task.name}
    return sorted(indices)


def _spread(indices: list[int], sample: int | None) -> tuple[int, ...]:
    """Return a sample of the instances, spread evenly."""
    if sample is None or sample >= len(indices):
        return tuple(indices)
    picked = {indices[(2 * i + 1) * len(indices) // (2 * sample)] for i in range(sample)}
    return tuple(i for i in indices if i in picked)
