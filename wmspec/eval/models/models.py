"""Models by name: `openai:NAME`, `hf:PATH`, or a baseline."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.models import baselines
from wmspec.eval.models.images import AS_THEY_ARE, ImageOptions
from wmspec.eval.models.model import Model
from wmspec.eval.models.question import questions
from wmspec.eval.models.server import Server, ServerModel


def open_model(
    name: str,
    dataset: DatasetReader,
    seed: int,
    parameters: dict[str, Any],
    server: Server | None,
    asks: int,
    defaults: frozenset[str] = frozenset(),
    images: ImageOptions = AS_THEY_ARE,
) -> Model:
    """Open a model by name; `defaults` names the parameters that no user chose.

    Raises WmsError if there is no such model, or if a requirement is missing.
    """
    kind, _, rest = name.partition(":")
    if kind == "openai" and rest and server is not None:
        return ServerModel(rest, server, parameters, asks, defaults)
    if kind == "hf" and rest:
        from wmspec.eval.models.local import LocalModel

        return LocalModel(Path(rest).expanduser(), parameters, images)
    if name in baselines.NAMES:
        ids = [row["id"] for task in dataset.tasks for row in dataset.rows(task, ["id"])]
        return baselines.Baseline(name, questions(dataset, ids, pictures=False), seed)
    hint = suggestion(name, baselines.NAMES)
    raise WmsError(
        f"--model {name}: expected openai:NAME, hf:PATH or {', '.join(baselines.NAMES)}; {hint}".rstrip("; ")
    )
