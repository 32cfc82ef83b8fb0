"""The public Python API; all other modules of wmspec may change.

The names are also those of `import wmspec`. Each is imported on first use, so that `import wmspec` is quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wmspec.api.agreement import Agreement as Agreement
    from wmspec.api.agreement import crosscheck as crosscheck
    from wmspec.api.environments import Environment as Environment
    from wmspec.api.environments import Problem as Problem
    from wmspec.api.environments import environment as environment
    from wmspec.api.episode import Episode as Episode
    from wmspec.api.episode import Track as Track
    from wmspec.api.episode import load_episode as load_episode
    from wmspec.api.episode import open_stage as open_stage
    from wmspec.api.episode import run as run
    from wmspec.api.generating import DatasetOptions as DatasetOptions
    from wmspec.api.generating import generate as generate
    from wmspec.api.loading import Diagnosis as Diagnosis
    from wmspec.api.loading import diagnose as diagnose
    from wmspec.api.loading import load as load
    from wmspec.api.loading import load_all as load_all
    from wmspec.api.progress import progress_bar as progress_bar
    from wmspec.api.rendering import RenderOptions as RenderOptions
    from wmspec.api.task import Factor as Factor
    from wmspec.api.task import Instance as Instance
    from wmspec.api.task import InstanceQuestions as InstanceQuestions
    from wmspec.api.task import Task as Task
    from wmspec.core.diagnostics import SpecError as SpecError
    from wmspec.core.diagnostics import WmsError as WmsError
    from wmspec.runtime.engines.registry import register as register

_NAMES = {
    "wmspec.api.agreement": ("Agreement", "crosscheck"),
    "wmspec.api.environments": ("Environment", "Problem", "environment"),
    "wmspec.api.episode": ("Episode", "Track", "load_episode", "open_stage", "run"),
    "wmspec.api.generating": ("DatasetOptions", "generate"),
    "wmspec.api.loading": ("Diagnosis", "diagnose", "load", "load_all"),
    "wmspec.api.progress": ("progress_bar",),
    "wmspec.api.rendering": ("RenderOptions",),
    "wmspec.api.task": ("Factor", "Instance", "InstanceQuestions", "Task"),
    "wmspec.core.diagnostics": ("SpecError", "WmsError"),
    "wmspec.runtime.engines.registry": ("register",),
}
#: Public name -> the module that defines it.
HOMES = {name: module for module, names in _NAMES.items() for name in names}

__all__ = list(HOMES)


def __getattr__(name: str) -> Any:
    if name not in HOMES:
        raise AttributeError(f"module 'wmspec' has no attribute {name!r}")
    return getattr(import_module(HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(HOMES)
