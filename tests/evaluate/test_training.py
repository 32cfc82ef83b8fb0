"""Training data in use: rewards equal scores, TRL trains on the folder, and a learner shows what it did not see."""

from __future__ import annotations

import base64
import importlib.util
import io
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray
from PIL import Image

from tests.audit.made import make, race
from tests.evaluate.loopback import loopback
from tests.evaluate.made import in_numbers, in_pictures, in_words
from tests.evaluate.test_evaluate import all_questions
from wmspec.cli import main
from wmspec.eval.models import prompt, results
from wmspec.eval.models.model import Reply
from wmspec.eval.models.request import Ask

#: TRL in an environment of its own: `make training` makes one.
TRAINING = Path(os.environ.get("WMSPEC_TRAINING", Path(__file__).parents[2] / "build/training/bin/python"))
HOLDOUT = "tone=red"
SHARES = "train=50,validation=0,test=50"


def wmspec(*args: object) -> str:
    done = CliRunner().invoke(main, [str(arg) for arg in args])
    assert done.exit_code == 0, done.output
    return done.output


def chats(folder: Path) -> list[dict[str, Any]]:
    paths = sorted(folder.glob("*.jsonl"))
    return [json.loads(line) for path in paths for line in path.read_text().splitlines()]


def load_reward(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(folder))
    for name in [name for name in sys.modules if name.partition(".")[0] == "wmspec_reply"]:
        monkeypatch.delitem(sys.modules, name)
    spec = importlib.util.spec_from_file_location("reward", folder / "reward.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("make_dataset", [in_words, in_pictures, in_numbers])
def test_the_reward_of_a_reply_is_its_score(
    make_dataset: Callable[[Path, int], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dataset = make_dataset(tmp_path / "d", 2)
    wmspec("export", dataset, "--to", "chat", "-o", tmp_path / "x")
    reward = load_reward(tmp_path / "x", monkeypatch)
    known = {question.id: question for question in all_questions(dataset, pictures=False)}
    listed = chats(tmp_path / "x")
    assert {chat["id"] for chat in listed} == set(known)
    for chat in listed:
        request = Ask(known[chat["id"]], prompt.load("default"))
        true = chat["messages"][-1]["content"][0]["text"]
        replies = [true, "A", "It is not B. So A.", "A or B", "", "0.51 m", "51 cm"]
        right = [results.row(request, Reply(reply), "m", "default")["right"] for reply in replies]
        assert right[0]
        truths = [chat["truth"]] * len(replies)
        assert reward.reward(replies, truth=truths, seen=None) == right
        for content in (str, lambda reply: [{"type": "text", "text": reply}]):
            said = [[{"role": "assistant", "content": content(reply)}] for reply in replies]
            assert reward.reward(said, truth=truths) == right


@pytest.mark.slow
@pytest.mark.skipif(not TRAINING.exists(), reason="TRL has an environment of its own: make training")
@pytest.mark.parametrize("method", ["sft", "grpo"])
def test_trl_trains_a_tiny_model(method: str, tmp_path: Path) -> None:
    wmspec("export", in_pictures(tmp_path / "d", 12), "--to", "chat", "-o", tmp_path / "x", "--shares", SHARES)
    env = {**os.environ, "HF_HOME": str(tmp_path / "hf"), "OMP_NUM_THREADS": "1", "HF_HUB_OFFLINE": "1"}
    tiny = "import sys, pathlib, tiny; tiny.make(pathlib.Path(sys.argv[1]))"
    command = [TRAINING, "-c", tiny, tmp_path / "tiny"]
    subprocess.run([*map(str, command)], check=True, cwd=Path(__file__).parent, env=env)
    options = {
        "max_steps": 2, "per_device_train_batch_size": 2, "learning_rate": 0.01, "use_cpu": "true", "bf16": "false",
        "logging_steps": 1, "eval_strategy": "no",
    } | ({"num_generations": 2, "max_completion_length": 4} if method == "grpo" else {})  # fmt: skip
    command = [TRAINING, tmp_path / "x/train.py", tmp_path / "tiny", tmp_path / "tuned", "--method", method]
    command += [word for name, value in options.items() for word in ("--set", f"{name}={value}")]
    subprocess.run([*map(str, command)], check=True, env=env)
    state = json.loads(next((tmp_path / "tuned").glob("checkpoint-*/trainer_state.json")).read_text())
    steps = [line for line in state["log_history"] if "loss" in line]
    assert len(steps) == 2
    assert all(np.isfinite(step["loss"]) for step in steps)
    if method == "sft":
        before, after = (path.read_bytes() for path in _weights(tmp_path))
        assert before != after
    else:
        assert all(0 <= step["reward"] <= 1 for step in steps)


def _weights(folder: Path) -> tuple[Path, Path]:
    first, second = ((folder / name / "model.safetensors") for name in ("tiny", "tuned"))
    return first, second


# ---------------------------------------------------------------- a learner


def _decoded(png: bytes) -> NDArray[np.int64]:
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=np.int64)


def _features(pictures: list[NDArray[np.int64]]) -> tuple[tuple[int, ...], float]:
    """The colour of the upper ball, and how much further it goes than the lower one (px)."""
    half = pictures[0].shape[0] // 2
    background = pictures[0][0, 0]
    far: list[float] = []
    tone: tuple[int, ...] = ()
    for rows in (slice(0, half), slice(half, None)):
        places = []
        for shown in pictures:
            ball = (np.abs(shown[rows] - background).sum(-1) > 60).any(0)
            angle = np.angle(np.exp(2j * np.pi * np.flatnonzero(ball) / len(ball)).sum())
            places.append(angle / (2 * np.pi) * len(ball))
        far.append((places[1] - places[0]) % len(ball))
        if rows.start == 0:
            upper = pictures[0][rows].reshape(-1, 3)
            ball_pixels = upper[np.abs(upper - background).sum(-1) > 60]
            tone = tuple(int(c) for c in np.round(np.median(ball_pixels, axis=0) / 16))
    return tone, far[0] - far[1]


class Learner:
    """A model with a weight for each colour that it saw in training, fitted to the answers of chats."""

    def __init__(self, folder: Path) -> None:
        seen: dict[tuple[int, ...], list[tuple[float, float]]] = {}
        for line in (folder / "train.jsonl").read_text().splitlines():
            chat = json.loads(line)
            pictures = [_decoded((folder / name).read_bytes()) for name in chat["images"]]
            tone, further = _features(pictures)
            upper = chat["messages"][-1]["content"][0]["text"] == self._label(chat["messages"][-2]["content"])
            seen.setdefault(tone, []).append((further, 1.0 if upper else -1.0))
        self.weights = {
            tone: sum(x * y for x, y in pairs) / sum(x * x for x, _ in pairs) for tone, pairs in seen.items()
        }

    def _label(self, parts: list[Any]) -> str:
        """The label of the upper ball."""
        text = "\n".join(part["text"] for part in parts if part["type"] == "text")
        return re.findall(r"(?m)^([A-Z])\. the upper", text)[0]

    def reply(self, parts: list[Any]) -> str:
        urls = [part["image_url"]["url"] for part in parts if part["type"] == "image_url"]
        tone, further = _features([_decoded(base64.b64decode(url.partition(",")[2])) for url in urls])
        score = self.weights.get(tone, 0.0) * further
        upper = self._label(parts)
        other = "B" if upper == "A" else "A"
        return upper if score > 0 else other if score < 0 else "A"


def gap(dataset: Path, folder: Path, *holdout: str) -> dict[str, Any]:
    """The report's line on a learner that was trained without the hold-outs, if any."""
    wmspec("export", dataset, "--to", "chat", "-o", folder / "chats", "--shares", SHARES, *holdout)
    learner, out = Learner(folder / "chats"), folder / "learner.parquet"
    with loopback(learner.reply) as server:
        args = ("--base-url", server.address, "-o", out, "--split", "test", "--shares", SHARES)
        wmspec("evaluate", dataset, "-m", "openai:right", *args)
    wmspec("report", out, "--dataset", dataset, "-o", folder / "report", "--holdout", HOLDOUT)
    (line,) = json.loads((folder / "report/report.json").read_text())["seen"]
    return dict(line)


@pytest.mark.slow
def test_a_learner_shows_what_it_did_not_see(tmp_path: Path) -> None:
    pytest.importorskip("openai")
    pytest.importorskip("pandas")
    dataset = make(tmp_path / "d", "race", race(), 320)
    trained = gap(dataset, tmp_path / "a", "--holdout", HOLDOUT)
    assert trained["seen"]["value"] > 0.9
    assert trained["unseen"]["value"] == pytest.approx(0.5, abs=0.2)
    assert trained["gap"]["low"] > 0.1
    whole = gap(dataset, tmp_path / "b")
    assert whole["seen"]["value"] > 0.9
    assert whole["gap"]["low"] < 0.05
