"""Accuracy of robot arms: `python -m benchmarks.arms OUT.jsonl N [ENGINES]`, then `... OUT.jsonl`.

Runs N random episodes per kind. Measures the final error of the object (mm, degrees), and the processor time per second
of the episode. Results in OUT are not repeated.
"""

from __future__ import annotations

import json
import sys
import time
from collections import defaultdict
from pathlib import Path

import numpy as np

import wmspec

WORLD = """task one : custom {{
  object floor {{ shape: box  size: (4 m, 4 m, 4 cm)  at: (0, 0, -2 cm)  friction: 0.5  fixed: true }}
  {arms}
  object thing {{ shape: box  size: ({size})  density: 500 kg/m^3  on: floor at ({x} mm, {y} mm) }}
  {acts}
  horizon {end} s
  camera near {{ at: (0, -1 m, 1 m) }}
  observe near at [0 s]
}}"""
ONE = "robot arm : panda { at: (0, 53 cm, 0)  yaw: -90 deg }"
TWO = "robot a : panda { at: (-66 cm, 0, 0)  yaw: 0 deg } robot b : panda { at: (66 cm, 0, 0)  yaw: 180 deg }"
ENGINES = ("mujoco", "pybullet", "sapien")
WAYS = {"left": (-1, 0), "right": (1, 0), "away": (0, 1), "nearer": (0, -1)}


def episode(kind: str, number: int) -> tuple[str, np.ndarray, float, int]:
    """Return the spec of an episode, the intended displacement (3,) m, and the rotation angle (rad) and axis."""
    rng = np.random.default_rng([number, *kind.encode()])
    x, y = rng.integers(-80, 80), rng.integers(-60, 30)
    high, way = int(rng.integers(60, 140)), str(rng.choice(list(WAYS)))
    arms, size, turned, axis = ONE, "6 cm, 5 cm, 6 cm", 0.0, 3
    if kind == "pick, rotate, place":
        angle, to = int(rng.integers(-60, 60)), rng.integers(-120, 120, 2) * (1, 0.4)
        acts, end = (
            f"""action grab = arm.pick(thing, height: {high} mm) for 3.4 s
          action twist = arm.rotate(thing, angle: {angle} deg) for 2 s after grab
          action put = arm.place(thing, on: floor, at: ({to[0]} mm, {to[1]} mm)) for 5 s after twist""",
            10.6,
        )
        moved, turned = np.array([to[0] - x, to[1] - y, 0]) / 1000, np.radians(angle)
    elif kind == "push":
        far = int(rng.integers(80, 150))
        acts, end = f"action go = arm.push(thing, direction: {way}, distance: {far} mm) for 6 s", 6.2
        moved = np.array([*WAYS[way], 0]) * far / 1000
    elif kind == "push, pick":
        far, way = int(rng.integers(80, 150)), str(rng.choice(["left", "right"]))
        acts, end = (
            f"""action go = arm.push(thing, direction: {way}, distance: {far} mm) for 6 s
          action grab = arm.pick(thing, height: {high} mm) for 3.4 s after go""",
            9.6,
        )
        moved = np.array([*WAYS[way], 0]) * far / 1000 + (0, 0, high / 1000)
    elif kind == "lift, two arms":
        low, top = rng.integers(30, 110, 2)
        arms, size, axis = TWO, "34 cm, 6 cm, 3 cm", 2
        acts, end = (
            f"""action up = a.lift(thing, height: {low} mm) for 3.6 s
          action too = b.lift(thing, height: {top} mm) for 3.6 s with up""",
            4.0,
        )
        moved, turned = np.array([0, 0, (low + top) / 2000]), -float(np.arcsin((top - low) / 290))
    else:
        far, near = rng.integers(60, 110, 2)
        arms, size = TWO, "14 cm, 14 cm, 8 cm"
        acts, end = (
            f"""action go = a.push(thing, direction: right, distance: {far} mm) for 6 s
          action too = b.push(thing, direction: {(word := str(rng.choice(["away", "nearer"])))}, distance: {near} mm)
            for 6 s with go""",
            6.2,
        )
        moved = np.array([far, near * WAYS[word][1], 0]) / 1000
    text = '"""Arms: measured."""\n' + WORLD.format(arms=arms, size=size, x=x, y=y, acts=acts, end=end)
    return text, moved, turned, axis


KINDS = ("pick, rotate, place", "push", "push, pick", "lift, two arms", "push, two arms")


def measure(kind: str, number: int, engine: str) -> dict[str, object]:
    """Run one episode in one engine."""
    text, moved, turned, axis = episode(kind, number)
    row: dict[str, object] = {"kind": kind, "number": number, "engine": engine}
    try:
        instance = wmspec.load(text=text)[0]
        begun = time.process_time()
        instance.stage()
        staged = time.process_time()
        run = instance.run(engine)
        done = time.process_time()
    except wmspec.WmsError as error:
        return {**row, "error": str(error)}
    track = run["thing"]
    expected = np.zeros(4)
    expected[0], expected[axis] = np.cos(turned / 2), np.sin(turned / 2)
    off = float(np.linalg.norm(track.position[-1] - track.position[0] - moved))
    angle = float(np.degrees(2 * np.arccos(min(1.0, abs(expected @ track.orientation[-1])))))
    return {**row, "mm": 1000 * off, "deg": angle, "stage_s": staged - begun, "run_s": (done - staged) / run.time[-1]}


def table(rows: list[dict[str, object]]) -> None:
    """Print the results."""
    groups = defaultdict(list)
    for row in rows:
        groups[str(row["kind"]), str(row["engine"])].append(row)
    print("kind | engine | episodes | failed | mm: median, worst | degrees: worst | stage (s) | run (s/s)")
    for (kind, engine), every in sorted(groups.items()):
        good = [row for row in every if "mm" in row]
        mm, deg, stage, run = (np.array([row[name] for row in good]) for name in ("mm", "deg", "stage_s", "run_s"))
        if good:
            print(
                f"{kind} | {engine} | {len(every)} | {len(every) - len(good)} | {np.median(mm):.3f}, {mm.max():.3f} | "
                f"{deg.max():.3f} | {np.median(stage):.2f} | {np.median(run):.2f}"
            )


def main() -> None:
    """Run and report."""
    path = Path(sys.argv[1])
    rows = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    known = {(row["kind"], row["number"], row["engine"]) for row in rows}
    engines = tuple(sys.argv[3].split(",")) if len(sys.argv) > 3 else ENGINES
    for number in range(int(sys.argv[2]) if len(sys.argv) > 2 else 0):
        for kind in KINDS:
            for engine in engines:
                if (kind, number, engine) not in known:
                    rows.append(measure(kind, number, engine))
                    with path.open("a") as file:
                        file.write(json.dumps(rows[-1]) + "\n")
    table(rows)


if __name__ == "__main__":
    main()
