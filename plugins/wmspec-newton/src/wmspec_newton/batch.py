"""Executes many scenes at once: as the worlds of one model of Newton, which MuJoCo-Warp steps together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wmspec.core.diagnostics import EngineError
from wmspec.core.native_output import silence
from wmspec.sim.scene.model import Scene, Trace
from wmspec.sim.scene.physics.episode import Episode, Recording, kinematic_recording, play_together
from wmspec.sim.scene.physics.rigid import Assembly
from wmspec.sim.scene.physics.to_trace import trace

from .info import INFO
from .physics import arguments, prepare, verify
from .world import World, options

with silence():
    import newton
    import warp

MOST_CONTACTS = 8  # of a pair of shapes
MOST_ROWS = 4000  # of constraints in a world
PAIRED = ("pair_solref", "pair_solreffriction", "pair_solimp", "pair_margin", "pair_gap", "pair_friction")
STATES = ("joint_q", "joint_qd", "body_q", "body_qd", "body_f")


def execute_all(scenes: Sequence[Scene], device: str | None = None) -> list[Trace]:
    """Return the traces of scenes, executed together on a `device` of Warp: the GPU if there is one.

    Only scenes of equal structure share a model: the same bodies, joints and kinds of shapes in the same order, and the
    same time step. Sizes, masses, materials, places, motions and durations may differ.

    Raises WmsError for a scene that Newton does not support, EngineError if Newton fails.
    """
    prepared = [prepare(scene) for scene in scenes]
    recordings: dict[int, Recording] = {}
    groups: dict[str, list[int]] = {}
    for i, one in enumerate(prepared):
        if (recording := kinematic_recording(one[1])) is not None:
            recordings[i] = recording
        else:
            groups.setdefault(structure(*one), []).append(i)
    for group in groups.values():
        made = record([scenes[i] for i in group], [prepared[i] for i in group], device)
        recordings.update(zip(group, made, strict=True))
    return [trace(INFO.name, scene, prepared[i][1], recordings[i]) for i, scene in enumerate(scenes)]


def structure(whole: Assembly, timeline: Episode) -> str:
    """Return what the worlds of a model have in common, as text."""
    kinds = [(body.motion, [(piece.kind, piece.material[1] > 0) for piece in body.pieces]) for body in whole.bodies]
    trees = [[(n.parent, n.body, n.kind, bool(n.limits), bool(n.drive)) for n in tree] for tree in whole.trees]
    closures = [(tie.first, tie.second, len(tie.above)) for tie in whole.loop_closures]
    gears = [(gear.body, gear.leader) for gear in whole.mimic_constraints]
    grips = [(grip.hand, grip.body, len(grip.points)) for grip in timeline.grips]
    return repr((whole.step, kinds, trees, closures, gears, grips, sorted(whole.non_colliding_pairs)))


def record(
    scenes: Sequence[Scene], prepared: Sequence[tuple[Assembly, Episode]], device: str | None
) -> list[Recording]:
    """Return the recordings of scenes of equal structure."""
    with silence():
        worlds = [Member(*arguments(*one)) for one in prepared]
        batch = Batch(worlds, device)
        for world, scene in zip(worlds, scenes, strict=True):
            verify(world, scene)
        try:
            return play_together(worlds, [timeline for _, timeline in prepared], batch.step)
        except FloatingPointError as error:
            raise EngineError(f"Newton failed: {error}; look for overlaps or extreme velocities") from error


class Member(World):
    """A world of a batch. Its links and joints have the numbers of the whole model."""

    batch: Batch
    at: int

    def enter(self) -> None:
        """Wait for the batch, which calls `join`."""

    def join(self, batch: Batch, at: int) -> None:
        """Become world number `at` of a batch, and set the start."""
        self.batch, self.at = batch, at
        self.model, self.now, self.control, self.solver = batch.host, batch.now, batch.control, batch.solver
        for numbers, count in ((self.links, self.model.body_count), (self.joints, self.model.joint_count)):
            for body in numbers:
                numbers[body] += at * count // len(batch.worlds)
        before = at * self.model.shape_count // len(batch.worlds)
        self.shapes = {before + shape: body for shape, body in self.shapes.items()}
        self.pair()
        self.begin()

    def pair(self) -> None:
        """Set the parameters of contacts: MuJoCo sorts the pairs, and Newton 1.8 overlooks that in worlds."""
        given, model = self.model.mujoco, self.solver.mj_model
        shapes = np.sort(self.order()[np.stack([model.pair_geom1, model.pair_geom2], axis=1)], axis=1).tolist()
        known = np.sort(np.stack([given.pair_geom1.numpy(), given.pair_geom2.numpy()], axis=1), axis=1).tolist()
        rows = {tuple(pair): row for row, pair in enumerate(known)}
        places = [rows[tuple(pair)] for pair in shapes]
        for name in PAIRED:
            self.column(name)[:] = getattr(given, name).numpy()[places]

    def order(self) -> Any:
        """Return Newton's number of each shape of MuJoCo."""
        return self.solver.mjc_geom_to_newton_shape.numpy()[self.at]

    def freedom(self, body: int) -> int:
        """Return the number of the first degree of freedom of a body in MuJoCo."""
        first = self.at * self.model.joint_count // len(self.batch.worlds)
        return int(self.solver.mj_qd_start.numpy()[self.joints[body] - first])

    def column(self, name: str) -> Any:
        """Return this world's row of an array of MuJoCo's model or data, into which one may write."""
        return self.batch.column(name)[self.at]

    def reweigh(self) -> None:
        """Tell the solver that masses have changed."""
        self.batch.heavier = True

    def contacts(self) -> tuple[Any, Any]:
        """Return MuJoCo's shapes (n, 2) and the gaps (n,), m, of the contacts of the last step."""
        return self.batch.contacts(self.at)


class Batch:
    """Worlds in one model on a device, and their states on the host, which the worlds read and change."""

    def __init__(self, worlds: Sequence[Member], device: str | None) -> None:
        self.worlds = worlds
        builder = newton.ModelBuilder()
        newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
        for world in worlds:
            builder.add_world(world.builder)
        self.model, self.host = builder.finalize(device=device), builder.finalize(device="cpu")
        for model in (self.model, self.host):
            for at, world in enumerate(worlds):
                model.set_gravity(tuple(world.assembly.gravity), world=at)
        pairs = len(self.model.mujoco.pair_world) // len(worlds)
        most = max(1, MOST_CONTACTS * pairs)
        self.solver = newton.solvers.SolverMuJoCo(
            self.model, separate_worlds=True, njmax=MOST_ROWS, nconmax=most, **options(worlds[0].assembly, self.model)
        )
        self.now, self.control = self.host.state(), self.host.control()
        self.before, self.after, self.order = self.model.state(), self.model.state(), self.model.control()
        self.seen = self.solver.observables({self.solver.ObservableKind.OVERFLOW})
        self.columns: dict[str, Any] = {}
        self.heavier = False
        for at, world in enumerate(worlds):
            world.join(self, at)

    def column(self, name: str) -> Any:
        """Return a copy of an array of MuJoCo's model or data (worlds, ...), which replaces it before the next step."""
        return self.columns.setdefault(name, self.array(name).numpy().copy())

    def array(self, name: str) -> Any:
        """Return an array of MuJoCo's model or data on the device."""
        return getattr(self.solver.mjw_data if name == "eq_active" else self.solver.mjw_model, name)

    def step(self) -> None:
        """Advance all worlds by one step. Raises FloatingPointError if a world diverges or has too many contacts."""
        if self.heavier:
            for name in ("body_mass", "body_inv_mass", "body_inertia", "body_inv_inertia"):
                warp.copy(getattr(self.model, name), getattr(self.host, name))
            self.solver.notify_model_changed(newton.ModelFlags.BODY_INERTIAL_PROPERTIES)
            self.heavier = False
        for name, values in self.columns.items():
            self.array(name).assign(values)
        self.columns.clear()
        for name in STATES:
            warp.copy(getattr(self.before, name), getattr(self.now, name))
        warp.copy(self.order.joint_target_q, self.control.joint_target_q)
        step = self.worlds[0].step_size
        self.solver.step(self.before, self.after, self.order, None, step, observables=self.seen)
        for name in STATES:
            warp.copy(getattr(self.now, name), getattr(self.after, name))
        self.now.clear_forces()
        self.check()
        self.read()

    def check(self) -> None:
        """Raise FloatingPointError if a world diverges or has too many contacts."""
        if not np.isfinite(self.now.joint_q.numpy()).all():
            raise FloatingPointError("a position is not finite")
        if self.seen.overflow.numpy().any():
            raise FloatingPointError("there are more contacts than fit")

    def read(self) -> None:
        """Read the contacts of the last step, by world."""
        contact, count = self.solver.mjw_data.contact, int(self.solver.mjw_data.nacon.numpy()[0])
        worlds = contact.worldid.numpy()[:count]
        ordered = np.argsort(worlds, kind="stable")
        self.geoms, self.gaps = contact.geom.numpy()[:count][ordered], contact.dist.numpy()[:count][ordered]
        self.ends = np.searchsorted(worlds[ordered], np.arange(len(self.worlds) + 1))

    def contacts(self, at: int) -> tuple[Any, Any]:
        """Return the shapes (n, 2) and gaps (n,), m, of the contacts of a world."""
        part = slice(self.ends[at], self.ends[at + 1])
        return self.geoms[part], self.gaps[part]
