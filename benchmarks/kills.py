"""Runs that are killed at random moments, begun again until they end, and held against one that was left alone.

    python -m benchmarks.kills --of generate --kills 100
    python -m benchmarks.kills --of evaluate --kills 100
    python -m benchmarks.kills --of study --kills 100

Every process of a run is killed at once (SIGKILL), as when a machine goes down. Nothing that was kept may be lost, and
no byte of what comes out may differ; the exit code is 1 if it does.
"""

from __future__ import annotations

import argparse
import http.client
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import pyarrow.parquet as pq

from tests.dataset.made import make as make_dataset
from tests.dataset.made import plan
from tests.evaluate.loopback import loopback
from tests.evaluate.made import in_words
from tests.study.visitor import Process, letter, post
from wmspec.study import store
from wmspec.study.make import Options, make
from wmspec.study.model import load
from wmspec.study.store import Store
from wmspec.write.reader import DatasetReader

ROOT = Path(__file__).parent.parent
SPEC = ROOT / "tests/endtoend/specs/speed_tabletop.wms"
INSTANCES = 80
#: Seconds.
SOON = 1.5


class Failed(Exception):
    """A run lost something, or came to something else."""


def start(arguments: Sequence[str]) -> subprocess.Popen[bytes]:
    """The command line in a process group of its own."""
    quiet = subprocess.DEVNULL
    command = [sys.executable, "-m", "wmspec", *arguments]
    return subprocess.Popen(command, stdout=quiet, stderr=quiet, start_new_session=True)


def kill(run: subprocess.Popen[bytes]) -> bool:
    """Kill a run with its workers; returns whether it was still going on."""
    alive = run.poll() is None
    if alive:
        os.killpg(run.pid, signal.SIGKILL)
    run.wait()
    return alive


class Rounds:
    """A command that is killed over and over, from nothing to its end, again and again."""

    def __init__(
        self,
        arguments: Sequence[str],
        progress: Callable[[], set[str]],
        made: Callable[[], object],
        clear: Callable[[], None],
    ) -> None:
        self.arguments, self.progress, self.made, self.clear = arguments, progress, made, clear
        self.kills = self.early = self.rounds = 0

    def run(self, kills: int, chance: random.Random) -> None:
        """Kill it so often. Raises Failed if something was lost or differs."""
        began = time.monotonic()
        self._end(start(self.arguments))
        whole, longest = self.made(), time.monotonic() - began
        self.clear()
        before: set[str] = set()
        under_way = True
        while self.kills < kills or under_way:
            run = start(self.arguments)
            if self.kills < kills:
                self._wait(run, before, chance, longest)
                killed = kill(run)
            else:
                killed = False
            if killed:
                kept, under_way = self.progress(), True
                if before - kept:
                    raise Failed(f"lost: {sorted(before - kept)[:3]}")
                self.kills, self.early, before = self.kills + 1, self.early + (kept == before), kept
            else:
                self._end(run)
                if (result := self.made()) != whole:
                    raise Failed(f"another result than without kills: {_differing(result, whole)}")
                self.clear()
                self.rounds, before, under_way = self.rounds + 1, set(), False

    def _wait(self, run: subprocess.Popen[bytes], before: set[str], chance: random.Random, longest: float) -> None:
        """Wait for a random moment: three times of four, for one soon after something new was kept."""
        until = time.monotonic() + chance.uniform(0.0, longest)
        if chance.random() < 0.75:
            while run.poll() is None and self.progress() == before:
                time.sleep(0.02)
            until = time.monotonic() + chance.uniform(0.0, SOON)
        while run.poll() is None and time.monotonic() < until:
            time.sleep(0.002)

    def _end(self, run: subprocess.Popen[bytes]) -> None:
        if run.wait() != 0:
            raise Failed(f"it ended with exit code {run.returncode}")


def _differing(result: object, whole: object) -> str:
    """In which files or rows two results differ."""
    here, there = (dict(enumerate(r)) if isinstance(r, list) else r for r in (result, whole))
    if not isinstance(here, dict) or not isinstance(there, dict):
        return "they are of different kinds"
    return ", ".join(str(k) for k in sorted({*here, *there}, key=str) if here.get(k) != there.get(k))[:300]


def generate(home: Path) -> Rounds:
    """`INSTANCES` instances of one task in one engine, by two workers."""
    out = home / "out"
    arguments = ["generate", str(SPEC), "-o", str(out), "-b", "mujoco", "--per-task", str(INSTANCES), "--size", "48"]

    def progress() -> set[str]:
        kept = {p.name.partition("-")[0] for p in out.glob(".progress/*/*/*.instance")}
        files = [pq.read_table(p, columns=["index"])["index"] for p in out.glob("data/*/*.parquet")]
        rows = {str(i) for indices in files for i in indices.to_pylist()}
        return kept | rows

    def made() -> object:
        return {str(p.relative_to(out)): p.read_bytes() for p in sorted(out.rglob("*")) if p.is_file()}

    return Rounds([*arguments, "-j", "2"], progress, made, lambda: shutil.rmtree(out))


def evaluate(home: Path, address: str) -> Rounds:
    """Questions put to a server, which is slow to answer."""
    dataset, out = in_words(home / "dataset"), home / "results" / "r.parquet"
    journal = out.with_suffix(".journal.jsonl")
    arguments = ["evaluate", str(dataset), "-m", "openai:first+slow", "--base-url", address, "-o", str(out)]

    def progress() -> set[str]:
        lines = []
        with suppress(FileNotFoundError):  # what it holds is in the results now
            lines = journal.read_bytes().split(b"\n")[1:-1]
        replies = [json.loads(line) for line in lines] + (pq.read_table(out).to_pylist() if out.exists() else [])
        return {f"{r['id']} {r['permutation']} {r['sample']} {r['text']}" for r in replies}

    def made() -> object:
        table = pq.read_table(out)
        return table.drop_columns(["seconds"]).to_pylist()  # how long the server took is no matter of kills

    return Rounds([*arguments, "--concurrency", "3"], progress, made, lambda: shutil.rmtree(out.parent))


def main() -> None:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--of", choices=("generate", "evaluate", "study"), default="generate")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    chance = random.Random(options.seed)  # noqa: S311
    with tempfile.TemporaryDirectory(prefix="kills") as home, loopback() as server:
        if options.of == "study":
            print(study(Path(home), options.kills, chance))
            return
        rounds = generate(Path(home)) if options.of == "generate" else evaluate(Path(home), server.address)
        try:
            rounds.run(options.kills, chance)
        except Failed as error:
            print(f"FAILED after {rounds.kills} kills: {error}")
            sys.exit(1)
    print(
        f"{options.of}: {rounds.kills} kills in {rounds.rounds} runs that came to their end, {rounds.early} of them "
        "before anything new was kept: nothing lost, the same result every time"
    )


def _killed(server: Process, path: str, body: dict[str, object], delay: float) -> dict[str, object]:
    """Send an answer to a server that is killed meanwhile and begun again; then send it once more, as a page does."""
    sending = threading.Thread(target=_tried, args=(server.port, path, body))
    sending.start()
    time.sleep(delay)
    server.kill()
    sending.join()
    server.begin()
    return _said(server.port, path, body)


def _tried(port: int, path: str, body: dict[str, object]) -> None:
    with suppress(OSError, http.client.HTTPException, ValueError):
        post(port, path, body)


def _said(port: int, path: str, body: dict[str, object]) -> dict[str, object]:
    status, value = post(port, path, body)
    if status != 200:
        raise Failed(f"{path}: status {status}")
    return dict(value)


def study(home: Path, kills: int, chance: random.Random) -> str:
    """Visitors answer a study and try again what is not heard, while its server is killed."""
    make_dataset(home / "dataset", plan(count=20, shard=8))
    killed = rounds = 0
    while killed < kills:
        folder = home / f"study-{rounds}"
        make(DatasetReader.open(home / "dataset"), Options(per_task=6, raters=3, check_every=6), folder)
        made, server = load(folder), Process(folder)
        heard: list[tuple[str, int]] = []
        for visitor in range(3):
            session = f"{visitor:032x}"
            place = _said(server.port, "/visits", {"session": session, "rater": f"r{visitor}"})
            slot = int(str(place["slot"]))
            for step in range(len(made.slots[slot])):
                body = {"step": step, "text": letter(made, slot, step), "seconds": 1.5}
                kept = _killed(server, f"/visits/{session}/answers", body, chance.uniform(0.0, 0.02))
                killed += 1
                if kept["done"] != list(range(step + 1)):
                    raise Failed(f"answers of {session}: {kept['done']}")
                heard.append((session, step))
        server.kill()
        rounds += 1
        if [(v.session, a.step) for v in Store(folder / store.FILE, made).visits() for a in v.answers] != heard:
            raise Failed("other answers than were given")
    return f"study: {killed} kills in {rounds} studies: every answer kept once"


if __name__ == "__main__":
    main()
