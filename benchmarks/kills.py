"""Kill runs at random moments, resume them until they finish, and compare with an undisturbed run.

    python -m benchmarks.kills --of generate --kills 100
    python -m benchmarks.kills --of generate --executor ray --kills 100
    python -m benchmarks.kills --of evaluate --kills 100
    python -m benchmarks.kills --of films --kills 100
    python -m benchmarks.kills --of study --kills 100

The kind of interruption is random: SIGKILL to all processes, as when a machine goes down; to the main process only,
which orphans its workers; to one worker, as when memory runs out; SIGTERM; or Ctrl-C (SIGINT to all processes), once or
repeatedly. The server of a study is killed. No stored result may be lost, no byte of the output may differ, no process
may stay, and no signal may cause a traceback; otherwise the exit code is 1.
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
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import pyarrow.parquet as pq

from tests.dataset.made import make as make_dataset
from tests.dataset.made import plan
from tests.evaluate.loopback import loopback
from tests.evaluate.made import in_words
from tests.study.visitor import Process, letter, post
from wmspec.api import generate as generate_dataset
from wmspec.core.crash import EXIT_CODE
from wmspec.dataset.build.films import read_frames
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.film.codec import encode_mp4
from wmspec.eval.clips.questions import film_questions
from wmspec.eval.models.question import Selection
from wmspec.eval.study import store
from wmspec.eval.study.make import StudyOptions, make
from wmspec.eval.study.model import load
from wmspec.eval.study.store import AnswerStore

ROOT = Path(__file__).parent.parent
SPEC = ROOT / "tests/endtoend/specs/speed_tabletop.wms"
FILMS = ROOT / "tests/films/specs/shove.wms"
INSTANCES = 80
#: Seconds.
SOON = 1.5
#: Seconds in which orphaned processes must end.
LINGER = 30.0
#: Processes of Ray that do no work.
AGENTS = (b"ray::DashboardAgent", b"ray::RuntimeEnvAgent")


class Failed(Exception):
    """A run lost something, or gave another result."""


class Victim:
    """The command line in a process group of its own."""

    def __init__(self, arguments: Sequence[str]) -> None:
        self._log = tempfile.TemporaryFile()  # noqa: SIM115  it lasts as long as the run
        command = [sys.executable, "-m", "wmspec", *arguments]
        self.run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=self._log, start_new_session=True)

    @property
    def alive(self) -> bool:
        """Whether it is still running."""
        return self.run.poll() is None

    def end(self) -> int:
        """Wait for the end of it and its processes; return its exit code."""
        code = self.run.wait()
        until = time.monotonic() + LINGER
        while self._left():
            if time.monotonic() > until:
                os.killpg(self.run.pid, signal.SIGKILL)
                raise Failed(f"processes of it are there {LINGER:g} s later")
            time.sleep(0.05)
        self._log.seek(0)
        output = self._log.read()
        if code == EXIT_CODE or b"Traceback" in output:
            raise Failed(f"it said {output.decode(errors='replace')[-2000:]}")
        return code

    def _left(self) -> bool:
        """Whether processes of it remain, except Ray's agents, which end a minute later."""
        for entry in Path("/proc").glob("[0-9]*"):
            pid = int(entry.name)
            with suppress(ProcessLookupError):
                if os.getpgid(pid) == self.run.pid and not any(agent in _command(pid) for agent in AGENTS):
                    return True
        return False

    def workers(self) -> list[int]:
        """Return its worker processes."""
        below, waiting = [], [self.run.pid]
        while waiting:
            for children in Path(f"/proc/{waiting.pop()}/task").glob("*/children"):
                with suppress(OSError):
                    pids = [int(pid) for pid in children.read_text().split()]
                    waiting += pids
                    below += pids
        return [pid for pid in below if any(name in _command(pid) for name in (b"spawn_main", b"ray::_Actor"))]


def _command(pid: int) -> bytes:
    with suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    return b""


def _all(victim: Victim) -> None:
    os.killpg(victim.run.pid, signal.SIGKILL)


def _alone(victim: Victim) -> None:
    victim.run.kill()


def _worker(victim: Victim) -> None:
    for pid in victim.workers()[-1:]:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def _terminated(victim: Victim) -> None:
    victim.run.terminate()


def _interrupted(victim: Victim) -> None:
    os.killpg(victim.run.pid, signal.SIGINT)


def _interrupted_again(victim: Victim) -> None:
    _interrupted(victim)
    time.sleep(0.05)
    with suppress(ProcessLookupError):
        _interrupted(victim)


#: Interruptions with their allowed exit codes; None if the run continues.
BLOWS: dict[str, tuple[Callable[[Victim], None], set[int] | None]] = {
    "all": (_all, {-signal.SIGKILL}),
    "run": (_alone, {-signal.SIGKILL}),
    "worker": (_worker, None),
    "SIGTERM": (_terminated, {128 + signal.SIGTERM, -signal.SIGTERM}),
    "SIGINT": (_interrupted, {128 + signal.SIGINT, -signal.SIGINT}),
    "SIGINT twice": (_interrupted_again, {128 + signal.SIGINT, -signal.SIGINT}),
}


class Rounds:
    """A command that is killed repeatedly until it finishes, several times."""

    def __init__(
        self,
        arguments: Sequence[str],
        progress: Callable[[], set[str]],
        made: Callable[[], object],
        clear: Callable[[], None],
        blows: Sequence[str] = tuple(BLOWS),
    ) -> None:
        self.arguments, self.progress, self.made, self.clear = arguments, progress, made, clear
        self.blows = blows
        self.kills: Counter[str] = Counter()
        self.early = self.rounds = 0

    def run(self, kills: int, chance: random.Random) -> None:
        """Kill it `kills` times. Raises Failed if something was lost or differs."""
        began = time.monotonic()
        self._done(Victim(self.arguments))
        whole, longest = self.made(), time.monotonic() - began
        self.clear()
        before: set[str] = set()
        under_way = True
        while self.kills.total() < kills or under_way:
            victim = Victim(self.arguments)
            ended = self.kills.total() < kills and self._ended(victim, before, chance, longest)
            if ended:
                kept, under_way = self.progress(), True
                if before - kept:
                    raise Failed(f"lost: {sorted(before - kept)[:3]}")
                self.early, before = self.early + (kept == before), kept
            else:
                self._done(victim)
                if (result := self.made()) != whole:
                    raise Failed(f"another result than without kills: {_differing(result, whole)}")
                self.clear()
                self.rounds, before, under_way = self.rounds + 1, set(), False

    def _ended(self, victim: Victim, before: set[str], chance: random.Random, longest: float) -> bool:
        """Interrupt at a random moment; return whether that ended the run."""
        blow = chance.choice(self.blows)
        self._wait(victim, before, chance, longest)
        if not victim.alive:
            return False
        strike, codes = BLOWS[blow]
        strike(victim)
        self.kills[blow] += 1
        if codes is None:
            return False
        code = victim.end()
        if code not in {*codes, 0}:
            raise Failed(f"{blow}: it ended with exit code {code}")
        return code != 0

    def _wait(self, victim: Victim, before: set[str], chance: random.Random, longest: float) -> None:
        """Wait for a random moment, in three of four cases soon after a new result."""
        until = time.monotonic() + chance.uniform(0.0, longest)
        if chance.random() < 0.75:
            while victim.alive and self.progress() == before:
                time.sleep(0.02)
            until = time.monotonic() + chance.uniform(0.0, SOON)
        while victim.alive and time.monotonic() < until:
            time.sleep(0.002)

    def _done(self, victim: Victim) -> None:
        if (code := victim.end()) != 0:
            raise Failed(f"it ended with exit code {code}")


def _differing(result: object, whole: object) -> str:
    """Return the files or rows in which two results differ."""
    here, there = (dict(enumerate(r)) if isinstance(r, list) else r for r in (result, whole))
    if not isinstance(here, dict) or not isinstance(there, dict):
        return "they are of different kinds"
    return ", ".join(str(k) for k in sorted({*here, *there}, key=str) if here.get(k) != there.get(k))[:300]


def generate(home: Path, executor: str) -> Rounds:
    """Set up `INSTANCES` instances of one task in one engine with two workers."""
    out = home / "out"
    arguments = ["generate", str(SPEC), "-o", str(out), "-b", "mujoco", "--per-task", str(INSTANCES), "--size", "48"]

    def progress() -> set[str]:
        kept = {p.name.partition("-")[0] for p in out.glob(".progress/*/*/*.instance")}
        files = [pq.read_table(p, columns=["index"])["index"] for p in out.glob("data/*/*.parquet")]
        rows = {str(i) for indices in files for i in indices.to_pylist()}
        return kept | rows

    def made() -> object:
        return {str(p.relative_to(out)): p.read_bytes() for p in sorted(out.rglob("*")) if p.is_file()}

    return Rounds([*arguments, "-j", "2", "--executor", executor], progress, made, lambda: shutil.rmtree(out))


def evaluate(home: Path, address: str) -> Rounds:
    """Set up an evaluation with a slow server."""
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

    blows = [blow for blow in BLOWS if blow != "worker"]  # threads ask
    return Rounds([*arguments, "--concurrency", "3"], progress, made, lambda: shutil.rmtree(out.parent), blows)


def films(home: Path) -> Rounds:
    """Set up the scoring of clips, which are the true films of the questions."""
    generate_dataset(FILMS, home / "dataset", per_task=8, backend="mujoco", size=64, film=12, film_size=(192, 112))
    dataset = DatasetReader.open(home / "dataset")
    (home / "clips").mkdir()
    for question in film_questions(dataset, Selection().ids(dataset)):
        frames = read_frames(dataset.folder, question.films[question.answer])[question.context - 1 :]
        (home / "clips" / f"{question.file_name}.mp4").write_bytes(encode_mp4(frames, question.rate, 20))
    out = home / "results" / "r.parquet"
    arguments = ["evaluate", str(home / "dataset"), "-m", f"clips:{home / 'clips'}", "-o", str(out)]

    seen: set[str] = set()

    def progress() -> set[str]:
        kept = {path.name for path in out.with_suffix(".clips").glob("*") if path.suffix != ".part"}
        seen.update(kept)
        return seen.copy() if out.exists() else kept  # results take the place of what was kept for them

    def made() -> object:
        rows = pq.read_table(out).to_pylist()
        return rows, {p.name: p.read_bytes() for p in sorted(out.parent.rglob("*")) if p.is_file() and p != out}

    blows = [blow for blow in BLOWS if blow != "worker"]
    return Rounds(arguments, progress, made, lambda: shutil.rmtree(out.parent), blows)


def main() -> None:
    """Run and report."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # which a shell has jobs in the background ignore
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--of", choices=("generate", "evaluate", "films", "study"), default="generate")
    parser.add_argument("--executor", choices=("local", "ray"), default="local", help="of generate")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    chance = random.Random(options.seed)  # noqa: S311
    with tempfile.TemporaryDirectory(prefix="kills") as home, loopback() as server:
        if options.of == "study":
            print(study(Path(home), options.kills, chance))
            return
        if options.of == "films":
            rounds = films(Path(home))
        elif options.of == "evaluate":
            rounds = evaluate(Path(home), server.address)
        else:
            rounds = generate(Path(home), options.executor)
        try:
            rounds.run(options.kills, chance)
        except Failed as error:
            print(f"FAILED after {rounds.kills.total()} kills: {error}")
            sys.exit(1)
    kinds = ", ".join(f"{count} {blow}" for blow, count in sorted(rounds.kills.items()))
    print(
        f"{options.of}: {rounds.kills.total()} kills ({kinds}) "
        f"in {rounds.rounds} runs that came to their end, {rounds.early} of them before anything new was kept: "
        "nothing lost, the same result every time"
    )


def _killed(server: Process, path: str, body: dict[str, object], delay: float) -> dict[str, object]:
    """Send an answer to a server that is killed meanwhile and restarted; then send it again, as a page does."""
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
    """Let participants answer a study with retries, while its server is killed."""
    make_dataset(home / "dataset", plan(count=20, shard=8))
    killed = rounds = 0
    while killed < kills:
        folder = home / f"study-{rounds}"
        make(DatasetReader.open(home / "dataset"), StudyOptions(per_task=6, raters=3, check_every=6), folder)
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
        if [
            (v.session, a.step) for v in AnswerStore(folder / store.ANSWERS_FILE, made).visits() for a in v.answers
        ] != heard:
            raise Failed("other answers than were given")
    return f"study: {killed} kills in {rounds} studies: every answer kept once"


if __name__ == "__main__":
    main()
