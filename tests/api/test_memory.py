"""What a process keeps: the pictures and renderers of a few sizes, however many it draws."""

from __future__ import annotations

import gc
from weakref import ref

from tests.engines import installed
from wmspec.api.rendering import MAX_RENDERERS, renderer_of
from wmspec.dataset.build.worker import Job, _pairs
from wmspec.dataset.film.group import _renders

SIDES = range(16, 48, 2)


def alive(made: list[ref[object]]) -> int:
    gc.collect()
    return sum(one() is not None for one in made)


def test_few_sizes_of_renderers_are_cached() -> None:
    installed("mujoco")
    assert alive([ref(renderer_of("mujoco", size=side)) for side in SIDES]) == MAX_RENDERERS
    assert renderer_of("mujoco", size=SIDES[-1]) is renderer_of("mujoco", size=SIDES[-1])


def test_engines_of_the_last_job_are_cached() -> None:
    installed("mujoco")
    jobs = [Job((), 0, ("mujoco",), (side, side), "all") for side in SIDES]
    assert alive([ref(_pairs(job)["mujoco"].renders) for job in jobs]) == 1
    assert _pairs(jobs[-1]) is _pairs(jobs[-1])


def test_two_sizes_of_films_are_cached() -> None:
    assert alive([ref(_renders("mujoco", side, side)) for side in SIDES]) == 2
