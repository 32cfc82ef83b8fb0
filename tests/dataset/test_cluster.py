"""A Ray cluster makes what one machine makes, whatever becomes of its machines."""

import hashlib
import sys
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from tests.crosscheck.test_pool import square
from wmspec.api import generate
from wmspec.cli import main
from wmspec.core.diagnostics import WmsError
from wmspec.core.resources import resource
from wmspec.runtime.workers.cluster import ray_cluster
from wmspec.runtime.workers.pool import JobFailure, map_batches

pytestmark = pytest.mark.skipif(find_spec("ray") is None, reason="Ray is not installed")
startable = pytest.mark.skipif(
    any(map(str.isspace, sys.executable)), reason="Ray starts no Python with a space in its path"
)
SPEC = resource("specs") / "perception" / "vision" / "shape_room.wms"


@pytest.fixture(autouse=True)
def foreign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ray's workers can import what is in this folder: in a checkout, another wmspec than the one that is installed."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Two machines, as Ray sees it. Importing Ray takes seconds, also of runs without these tests."""
    from ray.cluster_utils import Cluster

    head = {"num_cpus": 1, "include_dashboard": False}
    try:
        cluster = Cluster(initialize_head=True, head_node_args=head)
    except Exception:  # noqa: BLE001  Ray waits 15 s for its agent, which is too short beside other tests
        cluster = Cluster(initialize_head=True, head_node_args=head)
    cluster.add_node(num_cpus=1)
    try:
        yield cluster
    finally:
        cluster.shutdown()


def files(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_python_that_ray_cannot_start_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "/a folder/bin/python")
    with pytest.raises(WmsError, match="whose path has a space"), ray_cluster("", 1, 5, {}):
        pass


@startable
def test_ray_does_the_pieces_on_a_machine_of_the_same_version() -> None:
    """A cluster of one machine, begun for it."""
    with ray_cluster("", 1, 60, {}) as effort:
        done = dict(map_batches(square, [[(1,), (6,)], [(4,)]], effort))
        with (
            pytest.raises(WmsError, match=r"has wmspec .*, and this one 0\.0\.0"),
            ray_cluster("", 1, 60, {"wmspec": "0.0.0"}),
        ):
            pass
    assert done == {(1,): 1, (6,): JobFailure("error", "Unforeseen: at 0x..., all of it"), (4,): 16}


@pytest.mark.slow
@startable
def test_a_piece_costs_there_what_it_costs_here(cluster: Any) -> None:
    units = [[(1,), (2,)], [(6,), (3,)], [(4,)]]
    with ray_cluster(cluster.address, None, 5, {}) as effort:
        assert effort.workers == 2
        done = dict(map_batches(square, units, effort))
    assert done == {
        (1,): 1,
        (2,): JobFailure("crashed", "the worker process died twice (exit code 7)"),
        (6,): JobFailure("error", "Unforeseen: at 0x..., all of it"),
        (3,): JobFailure("timeout", "took longer than 5 s, twice"),
        (4,): 16,
    }


def test_missing_cluster_is_an_error(tmp_path: Path) -> None:
    command = ["generate", str(SPEC), "-o", str(tmp_path / "out"), "-b", "mujoco", "--per-task", "1"]
    reported = CliRunner().invoke(main, [*command, "--address", "auto"])
    assert reported.exit_code != 0
    assert "set `executor` to ray" in reported.output
    for address in ("127.0.0.1:1", "ray://127.0.0.1:10001", "somewhere"):
        reported = CliRunner().invoke(main, [*command, "--executor", "ray", "--address", address])
        assert reported.exit_code != 0
        assert f"there is no Ray cluster at `{address}`" in reported.output


@pytest.mark.slow
@startable
def test_a_machine_that_is_lost_changes_nothing(cluster: Any, tmp_path: Path) -> None:
    import ray

    choices: Any = {"backend": "mujoco", "per_task": 24, "size": 64, "seed": 3}
    generate(SPEC, tmp_path / "here", workers=1, **choices)
    lost = cluster.add_node(num_cpus=1)

    class Progress:
        """Takes a machine away once all three are at work: what it had to do then has to wait for the others."""

        def __init__(self) -> None:
            self.count = 0

        def __enter__(self) -> Any:
            return self

        def __exit__(self, *error: object) -> None: ...

        def __call__(self, task: str, count: int) -> None:
            self.count += count
            if self.count == 2:
                while ray.available_resources().get("CPU", 0) > 0:
                    time.sleep(0.1)
                cluster.remove_node(lost, allow_graceful=False)
                while sum(node["Alive"] for node in ray.nodes()) == 3:
                    time.sleep(0.1)

    watched = Progress()
    generate(
        SPEC,
        tmp_path / "there",
        executor="ray",
        address=cluster.address,
        progress=lambda total, words: watched,
        **choices,
    )
    assert watched.count > 2
    assert len(cluster.list_all_nodes()) == 2
    assert files(tmp_path / "there") == files(tmp_path / "here")
