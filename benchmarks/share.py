"""Speed of a task of 96 instances with 8 physics, compared with a loop in bare MuJoCo without sharing.

    python -m benchmarks.share [--size 256] [--native 12]

The loop executes the same episodes (truth, counterfactuals, perturbation) of the same models, and draws the same
pictures, for some instances separately. It uses MuJoCo's `mj_step` at the same rate, one `Renderer` per episode, and
PNGs of the same compression. It creates no questions and checks nothing. Both alternate in one process, measured in
processor time.
"""

from __future__ import annotations

import argparse
import os
import time

os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco
import numpy as np

import wmspec
from wmspec.backends.mujoco.mjcf import mjcf
from wmspec.backends.mujoco.physics import prepare
from wmspec.compile.design.design import Design
from wmspec.dataset.build.batching import batches
from wmspec.dataset.build.images import encode_png
from wmspec.dataset.build.worker import CacheStats, Job, make_instances
from wmspec.lang.check.ir.record import to_json
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.questions.robustness import DEFAULT_NUDGE
from wmspec.runtime.questions.runs import EnginePair, Run, execute, nudged
from wmspec.sim.scene.model import Scene

TASK = """
use room

task strike : custom {
  factor pace       in [55 cm/s, 80 cm/s, 105 cm/s, 130 cm/s]
  factor fill       in [150 g, 12 kg]
  factor ball_color in [red, blue, yellow, white]
  factor box_color  in [green, purple, orange]
  object crate { shape: cube  size: 14 cm  mass: fill  color: box_color  restitution: 0.8  on: floor at (20 cm, 0 cm) }
  object ball {
    shape: sphere  size: 14 cm  mass: 1 kg  color: ball_color  friction: 0  restitution: 0.8  damping: 0.8 Hz
    on: floor at (-17 cm, 0 cm)
  }
  action push = launch(ball, direction: right, speed: pace) at 0.1 s
  horizon 1.4 s
  camera wide { at: (10 cm, -185 cm, 112 cm)  look_at: (10 cm, 4 cm, 2 cm)  fov: 48 deg }
  observe wide at [0 s, 0.17 s, 0.24 s]
  question "Which picture shows how it ends?" {
    answer frame(wide, end)
    counterfactual each other pace
  }
}
"""


def main() -> None:
    """Print both times and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--native", type=int, default=12)
    chosen = parser.parse_args()
    spec = wmspec.load(text=TASK, tell=lambda _: None).spec
    job = Job((("strike", to_json(spec)),), 0, ("mujoco",), (chosen.size, chosen.size), "none")
    design, pair = Design(spec), EnginePair(TraceCache("mujoco"), RenderCache("mujoco", 8, 8))
    order = [piece for unit in batches(spec, 0, range(len(design))) for piece in unit]
    ours = bare = 0.0
    rows, shared = 0, CacheStats()
    for number, piece in enumerate(order):
        began = time.process_time()
        made = make_instances(job, "strike", piece)
        ours += time.process_time() - began
        rows, shared = rows + len(made.outcomes[0].rows), shared + made.shared
        if number * chosen.native // len(order) != (number - 1) * chosen.native // len(order):
            episodes = _episodes(design, piece[0], pair)
            began = time.process_time()
            for scene, times in episodes:
                native(scene, times, chosen.size)
            bare += time.process_time() - began
    ours, bare = 1e3 * ours / len(order), 1e3 * bare / chosen.native
    print(f"{len(order)} instances, {rows} questions; {shared}")
    print(f"wmspec {ours:.0f} ms of CPU an instance, the bare loop {bare:.0f} ms: {bare / ours:.1f} times as fast")


def _episodes(design: Design, index: int, pair: EnginePair) -> list[tuple[Scene, tuple[float, ...]]]:
    """Return the scenes of an instance, each with the times of its pictures."""
    instance, (question,) = design[index], design.spec.questions
    truth = execute(design, instance, None, pair)
    others: list[Run] = [execute(design, instance, c, pair) for c in question.alternatives(instance.factors)]
    end = truth.scene.duration
    aside = nudged(truth, DEFAULT_NUDGE, instance.key, pair)
    return [(truth.scene, (0.0, 0.17, 0.24, end)), *((run.scene, (end,)) for run in others), (aside.scene, ())]


def native(scene: Scene, times: tuple[float, ...], size: int) -> None:
    """Execute an episode and draw its pictures with MuJoCo's API only."""
    whole, timeline = prepare(scene)
    text = mjcf(scene, timeline, whole)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    renderer = mujoco.Renderer(model, size, size) if times else None
    kicks = {kick.step: kick for kick in timeline.kicks}
    pictures = {round(t / timeline.step) for t in times}
    address = model.jnt_dofadr[model.body_jntadr[model.body(scene.bodies[timeline.kicks[0].body].name).id]]
    positions = np.empty((timeline.samples, model.nq))
    for step in range((timeline.samples - 1) * timeline.substeps + 1):
        if step in kicks:
            data.qvel[address : address + 6] = [*kicks[step].linear, *kicks[step].angular]
        if step % timeline.substeps == 0:
            positions[step // timeline.substeps] = data.qpos
        if renderer and step in pictures:
            renderer.update_scene(data, camera=scene.cameras[0].name)
            encode_png(renderer.render())
        mujoco.mj_step(model, data)
    if renderer:
        renderer.close()


if __name__ == "__main__":
    main()
