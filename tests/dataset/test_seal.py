"""A sealed dataset tells nothing of itself, and is known again."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.command import wmspec
from tests.engines import installed
from tests.recipes.test_engine import FLIGHT
from wmspec.api import generate
from wmspec.api.attesting import attest, check
from wmspec.core.diagnostics import WmsError

SEED = 2**62 + 12345


@pytest.fixture(scope="module")
def private(tmp_path_factory: pytest.TempPathFactory) -> Path:
    installed("mujoco")
    folder = tmp_path_factory.mktemp("seal") / "private"
    generate(FLIGHT, folder, per_task=2, backend="mujoco", size=64, seed=SEED, workers=0)
    return folder


def test_sealed_dataset_is_recognized_and_no_other(private: Path, tmp_path: Path) -> None:
    attest(private, tmp_path / "public", workers=0)
    public = [path for path in (tmp_path / "public").rglob("*") if path.is_file()]
    assert all(str(SEED).encode() not in path.read_bytes() for path in public)
    ids = [shard["sha256"] for shard in json.loads((private / "manifest.json").read_bytes())["shards"].values()]
    debug = json.loads((tmp_path / "public" / "debug" / "manifest.json").read_bytes())
    assert debug["seed"] == 0
    assert not {shard["sha256"] for shard in debug["shards"].values()} & {*ids}

    done = wmspec("attest", private, "--check", tmp_path / "public" / "seal.json", folder=tmp_path)
    assert (done.exit_code, done.stdout) == (0, "this is the dataset that was sealed\n")
    again = tmp_path / "again"
    generate(FLIGHT, again, per_task=2, backend="mujoco", size=64, seed=SEED, workers=0)
    assert check(again, tmp_path / "public" / "seal.json") == ()
    other = tmp_path / "other"
    generate(FLIGHT, other, per_task=2, backend="mujoco", size=64, seed=SEED + 1, workers=0)
    assert check(other, tmp_path / "public" / "seal.json")[0] == "the seed differs"


def test_sealed_and_debug_datasets_share_a_renderer(tmp_path: Path) -> None:
    for engine in ("mujoco", "pybullet"):
        installed(engine)
    choices: Any = {"per_task": 1, "size": 48, "seed": SEED, "workers": 0}
    generate(FLIGHT, tmp_path / "private", backend="pybullet", renderer="mujoco", **choices)
    attest(tmp_path / "private", tmp_path / "public", workers=0)
    plans = [json.loads((tmp_path / one / "plan.json").read_bytes()) for one in ("private", "public/debug")]
    assert [plan["renderer"] for plan in plans] == ["mujoco", "mujoco"]


def test_a_seed_that_can_be_guessed_is_refused(tmp_path: Path) -> None:
    generate(FLIGHT, tmp_path / "out", per_task=1, backend="mujoco", size=64, seed=7, workers=0)
    with pytest.raises(WmsError, match="anyone can find by trying"):
        attest(tmp_path / "out", tmp_path / "public")
    assert not (tmp_path / "public").exists()


def test_a_seed_that_no_column_holds_is_refused(tmp_path: Path) -> None:
    with pytest.raises(WmsError, match="a seed is an integer from"):
        generate(FLIGHT, tmp_path / "out", per_task=1, backend="mujoco", seed=2**63)


def test_invalid_seal_is_an_error(private: Path, tmp_path: Path) -> None:
    (tmp_path / "seal.json").write_text("{}")
    for path in (tmp_path / "seal.json", tmp_path / "none.json"):
        with pytest.raises(WmsError, match="is no seal"):
            check(private, path)
