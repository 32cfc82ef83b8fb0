"""Executes the stages of `usdphysics-conformance write` in Newton and writes traces.

python newton_traces.py STAGES TRACES [CASE]...
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import newton
import numpy as np
import warp as wp
from pxr import Usd, UsdGeom

SUBSTEPS = 8  # of each sample: 1,920 steps a second


def executed(path: Path, seconds: float, rate: int) -> dict[str, np.ndarray]:
    """The trace of a stage, by Newton's solver on top of MuJoCo, on the processor."""
    stage = Usd.Stage.Open(str(path))
    builder = newton.ModelBuilder(up_axis=UsdGeom.GetStageUpAxis(stage))
    builder.add_usd(stage)
    # Newton moves jointed bodies only in articulations, for which UsdPhysics does not ask.
    if loose := [joint for joint, tree in enumerate(builder.joint_articulation) if tree < 0]:
        builder.add_articulation(loose)
    model = builder.finalize(device="cpu")
    solver = newton.solvers.SolverMuJoCo(model, iterations=100, ls_iterations=50, use_mujoco_cpu=True)
    now, after, control = model.state(), model.state(), model.control()
    newton.eval_fk(model, model.joint_q, model.joint_qd, now)
    samples = [read(now)]
    for _ in range(round(seconds * rate)):
        for _ in range(SUBSTEPS):
            now.clear_forces()
            solver.step(now, after, control, None, 1 / (rate * SUBSTEPS))
            now, after = after, now
        samples.append(read(now))
    names = [str(label).rpartition("/")[2] for label in model.body_label]
    parts = (np.array(part) for part in zip(*samples, strict=True))
    whole = dict(zip(("position", "orientation", "linear_velocity", "angular_velocity"), parts, strict=True))
    metres = UsdGeom.GetStageMetersPerUnit(stage)
    whole["position"] = whole["position"] * metres
    whole["linear_velocity"] = whole["linear_velocity"] * metres
    return {"bodies": np.array(names), **whole}


def read(state: newton.State) -> tuple[np.ndarray, ...]:
    """Positions, quaternions (w, x, y, z), velocities of the centres of mass, angular velocities of all bodies."""
    place, speed = state.body_q.numpy().astype(float), state.body_qd.numpy().astype(float)
    return place[:, :3], place[:, [6, 3, 4, 5]], speed[:, :3], speed[:, 3:]


def main() -> None:
    """Run the cases that are named, or all."""
    stages, traces, requested = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:]
    traces.mkdir(parents=True, exist_ok=True)
    wp.config.quiet, wp.config.enable_backward = True, False  # without derivatives kernels compile in less time
    for name, case in json.loads((stages / "cases.json").read_text()).items():
        target = traces / f"{name}.npz"
        if (requested and name not in requested) or target.exists():
            continue
        try:
            np.savez(target, **executed(stages / case["stage"], case["seconds"], case["rate"]))
        except Exception as error:  # noqa: BLE001  an engine may give up in any way, which is its score
            np.savez(target, refusal=f"{type(error).__name__}: {error}"[:300])
        print(name, flush=True)


if __name__ == "__main__":
    main()
