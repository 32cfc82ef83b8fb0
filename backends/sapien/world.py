"""The SAPIEN (PhysX) implementation of `wmspec.sim.scene.physics.episode.World`."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

import numpy as np

from wmspec.core.native_output import silence
from wmspec.sim.scene.joints.articulations import Link, LoopClosure
from wmspec.sim.scene.physics.episode import Grip
from wmspec.sim.scene.physics.rest import RestingWorld
from wmspec.sim.scene.physics.rigid import Assembly, Rigid

from .joints import ball, collision_words, connect, couple, frame, split_at_ball_joints
from .shapes import geometric_mean, groups, lanes, shape

with silence():
    import sapien

MAX_SPIN = 1000.0  # rad/s; PhysX's default is 100
MAX_SEPARATION_SPEED = 1.0  # m/s: largest separation speed of overlapping bodies; unlimited, bounces are too high
POSITION_ITERATIONS = 100  # an elastic impact loses 0.4 / n² of its speed
VELOCITY_ITERATIONS = 4
LANDING_ITERATIONS = 64  # for landings; with 4 a body rebounds with up to half its speed
JUMP_DISTANCE = 1e-9  # m: a larger distance from the target means a teleport


class World(RestingWorld):
    """A SAPIEN scene with the given bodies in order.

    PhysX averages materials, but the geometric mean is required. So each pair of materials has a lane, a bit of the
    collision groups: on it a shape has a copy with the lane's material, which collides with copies of the other
    material only. A single material needs one copy. `landing`: bodies that fall on others, and those below.
    """

    def __init__(self, assembly: Assembly, landing: Collection[int]) -> None:
        super().__init__(assembly)
        sapien.physx.set_scene_config(
            gravity=np.array(assembly.gravity, np.float32),
            bounce_threshold=0.01,  # m/s; the default of 2 suppresses bounces
            enable_pcm=True,
            enable_tgs=True,
            enable_ccd=False,
            enable_enhanced_determinism=True,
            enable_friction_every_iteration=True,
        )
        self.system = sapien.physx.PhysxCpuSystem()
        self.scene = sapien.Scene([self.system])
        self.scene.set_timestep(assembly.step)
        self.landing = landing
        self.targets: dict[int, Any] = {}
        self.moves: dict[int, tuple[Any, ...]] = {}
        self.moved: dict[int, int] = {}
        self.lanes = lanes(assembly.bodies)
        self.apart = set(assembly.non_colliding_pairs)
        self.ignored = collision_words(tuple(sorted(self.apart)), len(self.bodies))
        self.mimic_constraints, self.seconds = assembly.mimic_constraints, assembly.step
        self.joints: dict[int, Any] = {}
        made: dict[int, Any] = {}
        for i in range(len(self.bodies)):
            if i not in self.trees:
                made[i] = self.add(i)
            elif i not in made:
                for branch in split_at_ball_joints(self.trees[i]):
                    made |= self.grow(branch, made)
        self.parts = [made[i] for i in range(len(self.bodies))]
        self.numbers = {part: i for i, part in enumerate(self.parts)}
        for tie in assembly.loop_closures:
            self.tie(tie)

    def tie(self, tie: LoopClosure) -> None:
        """Close a loop."""
        first, second, above, below = tie.first, tie.second, tie.above, tie.below
        if second < 0:  # the world can only be the first body
            first, second, above, below = second, first, below, above
        for one, other in zip(above, below, strict=True):
            self.point(second, first, other, one)

    def point(self, body: int, parent: int, inner: Any, outer: Any) -> Any:
        """Hold a point of a body to one of another, or of the world."""
        ends = [sapien.Pose(np.array(at, np.float32)) for at in (inner, outer)]
        return ball(self.parts[body], self.parts[parent] if parent >= 0 else None, *ends)

    def add(self, number: int) -> Any:
        """Add a body; the name of its entity is its number."""
        physx, body = sapien.physx, self.bodies[number]
        part = physx.PhysxRigidStaticComponent() if body.motion == "static" else physx.PhysxRigidDynamicComponent()
        self.clothe(part, number)
        if body.motion == "dynamic":
            solve(part, body)
            iterate(part, LANDING_ITERATIONS if number in self.landing else VELOCITY_ITERATIONS)
        if body.motion == "kinematic":
            part.set_kinematic(True)
        self.scene.add_entity(entity(part, number, body.start))
        return part

    def clothe(self, part: Any, number: int) -> None:
        """Add the shapes of a body."""
        for piece in self.bodies[number].pieces:
            for pair, bit in self.lanes.items():
                if piece.material in pair:
                    meets = groups(piece.material, pair, bit)
                    part.attach(shape(piece, geometric_mean(*pair), [*meets, *self.ignored[number]]))

    def grow(self, branch: tuple[Link, ...], made: dict[int, Any]) -> dict[int, Any]:
        """Add a part of a tree without inner ball joints: an articulation, or a single body."""
        top = branch[0]
        if len(branch) == 1 and top.kind in ("free", "ball"):
            parts = {top.body: self.add(top.body)}
            if speeds := self.bodies[top.body].velocity:
                parts[top.body].set_linear_velocity(np.array(speeds[:3], np.float32))
                parts[top.body].set_angular_velocity(np.array(speeds[3:], np.float32))
        else:
            parts = self.articulate(branch)
        if top.kind == "ball":
            self.joints[top.joint] = ball(parts[top.body], made.get(top.parent), frame(top.below), frame(top.above))
        return parts

    def articulate(self, branch: tuple[Link, ...]) -> dict[int, Any]:
        """Add an articulation; a fixed link without shape carries links at the world."""
        physx, top = sapien.physx, branch[0]
        links: dict[int, Any] = {}
        geared = {
            limb.joint for gear in self.mimic_constraints for limb in branch if limb.body in (gear.body, gear.leader)
        }
        entities = []
        if top.kind not in ("free", "ball"):
            links[-1] = physx.PhysxArticulationLinkComponent(None)
            links[-1].joint.set_type("fixed")
            entities.append(entity(links[-1], -1, top.above))
        for limb in branch:
            parent = links.get(-1 if limb is top else limb.parent)
            link = links[limb.body] = physx.PhysxArticulationLinkComponent(parent)
            self.clothe(link, limb.body)
            solve(link, self.bodies[limb.body])
            entities.append(entity(link, limb.body, self.bodies[limb.body].start))
            if parent is not None:
                self.joints[limb.joint] = link.joint
                above = frame(limb.above) if limb.parent >= 0 else frame(top.above).inv() * frame(limb.above)
                connect(link.joint, limb, sapien.Pose() if limb is top else above, geared=limb.joint in geared)
        for one in entities:
            self.scene.add_entity(one)
        iterate(next(iter(links.values())).articulation, VELOCITY_ITERATIONS)
        self.rest(links, branch, moving=True)
        for gear in self.mimic_constraints:
            if gear.body in links:
                couple(gear, branch, links, self.seconds)
        return {body: link for body, link in links.items() if body >= 0}

    def rest(self, links: dict[int, Any], branch: tuple[Link, ...], *, moving: bool = False) -> None:
        """Reset an articulation to its start, with initial velocities if `moving`."""
        top = branch[0]
        speeds = (moving and self.bodies[top.body].velocity) or (0.0,) * 6
        articulation = links[top.body].articulation
        if top.kind in ("free", "ball"):
            articulation.set_root_pose(frame(self.bodies[top.body].start))
            articulation.set_root_linear_velocity(np.array(speeds[:3], np.float32))
            articulation.set_root_angular_velocity(np.array(speeds[3:], np.float32))
        limbs = {links[limb.body].index: limb for limb in branch}
        order = [limbs[joint.child_link.index] for joint in articulation.get_active_joints()]
        articulation.set_qpos(np.array([limb.start for limb in order], np.float32))
        rates = [limb.rate[0] if moving and limb.rate else 0.0 for limb in order]
        articulation.set_qvel(np.array(rates, np.float32))

    def kick(self, body: int, linear: Any, angular: Any, at: Any = None) -> None:
        """Set the velocities of a free body, and its pose if `at` is given."""
        self.stir()
        if at is not None:
            self.parts[body].entity.set_pose(frame(at))
        self.parts[body].set_linear_velocity(np.array(linear, np.float32))
        self.parts[body].set_angular_velocity(np.array(angular, np.float32))

    def driven(self, paths: Mapping[int, tuple[Any, Any, Any]]) -> Callable[[int], None]:
        """Return a function that sets targets of kinematic bodies before step i.

        Distant ones are placed on their paths at times only.
        """
        self.rest_detector.follow(paths)
        for body, (here, there, _) in paths.items():
            jumps = np.abs(there[:-1] - here[1:]).max(axis=1, initial=0.0) > JUMP_DISTANCE
            ends = there.astype(np.float32)
            self.moves[body] = here, there, ends[:, :3], ends[:, 3:], [True, *jumps.tolist()]

        def drive(i: int) -> None:
            rest = self.rest_detector
            if self.skipped is not None:
                self.resume()
            if not paths or self.loop_closures:
                self.move(i, paths)
                return
            if rest.neighbours(i, self.state) is None:
                for body in paths.keys() - rest.near:
                    self.place(body, paths[body][0][i])
            self.move(i, rest.near)

        return drive

    def move(self, i: int, bodies: Iterable[int] | None = None) -> None:
        """Set the targets of kinematic bodies for step `i`: of all, or of these."""
        for body in self.moves if bodies is None else bodies:
            here, there, places, turns, jumps = self.moves[body]
            if jumps[i] or self.moved.get(body) != i - 1:
                self.drive(body, here[i], there[i])
            else:
                self.parts[body].set_kinematic_target(sapien.Pose(places[i], turns[i]))
                self.targets[body] = there[i]
            self.moved[body] = i

    def place(self, body: int, here: Any) -> None:
        """Place a kinematic body, which stays there."""
        self.targets.pop(body, None)
        self.parts[body].entity.set_pose(frame(here))

    def drive(self, body: int, here: Any, there: Any) -> None:
        """Set the target of a kinematic body for the next step; teleport it first if it is off its path."""
        if np.abs(self.targets.get(body, here) - here).max() > JUMP_DISTANCE:
            self.parts[body].entity.set_pose(frame(here))
        self.targets[body] = there
        self.parts[body].set_kinematic_target(frame(there))

    def push(self, body: int, force: Any, torque: Any) -> None:
        """Apply a force and a torque at the centre of mass of a dynamic body during the next step."""
        self.stir()
        self.parts[body].add_force_torque(np.array(force, np.float32), np.array(torque, np.float32))

    def aim(self, joint: int, target: float) -> None:
        """Set the target of a drive."""
        self.stir()
        self.joints[joint].set_drive_target(target)

    def collide(self, one: int, other: int, collides: bool) -> None:
        """Set whether two bodies collide: all shapes get the collision groups of the new set of pairs."""
        self.stir()
        (self.apart.discard if collides else self.apart.add)((min(one, other), max(one, other)))
        for part, words in zip(self.parts, collision_words(tuple(sorted(self.apart)), len(self.bodies)), strict=True):
            for each in part.collision_shapes:
                each.set_collision_groups([*each.get_collision_groups()[:2], *words])

    def hold(self, body: int, at: Any = None) -> None:
        """Reset a dynamic body to its start or to `at`, and make a free one kinematic."""
        place = tuple(self.bodies[body].start if at is None else at)
        if body not in self.places or self.places[body][0] != place:
            self.stir()
            self.places[body] = place, np.array(place), frame(place)  # with array and SAPIEN's pose
            if body not in self.trees:
                self.parts[body].set_kinematic(True)
                if at is not None:
                    self.parts[body].entity.set_pose(frame(place))
        if not self.rest_detector.idle:
            self.keep(body)

    def keep(self, body: int) -> None:
        """Reset a held body to its place."""
        self.states.clear()
        if body not in self.trees:
            _, place, pose = self.places[body]
            if self.targets.get(body) is not place:
                self.drive(body, place, place)
            else:
                self.parts[body].set_kinematic_target(pose)
            return
        for branch in split_at_ball_joints(self.trees[body]):
            part = self.parts[branch[0].body]
            if isinstance(part, sapien.physx.PhysxArticulationLinkComponent):
                self.rest({limb.body: self.parts[limb.body] for limb in branch}, branch)
            else:
                part.entity.set_pose(frame(self.bodies[branch[0].body].start))
                self.kick(branch[0].body, np.zeros(3), np.zeros(3))

    def free(self, body: int) -> None:
        """Release a held body."""
        self.stir()
        self.places.pop(body, None)
        if body not in self.trees:
            self.parts[body].set_kinematic(False)

    def grip(self, number: int, grip: Grip, anchors: Any) -> None:
        """Tie points of a hand to anchors in the frame of a body."""
        self.stir()
        self.loop_closures[number] = [
            self.point(grip.body, grip.hand, anchor, point) for point, anchor in zip(grip.points, anchors, strict=True)
        ]

    def loose(self, number: int, grip: Grip) -> None:
        """Release a grip."""
        self.stir()
        for tie in self.loop_closures.pop(number):
            self.parts[grip.body].entity.remove_component(tie)

    def step(self) -> None:
        """Advance one step."""
        self.system.step()
        self.states.clear()
        self.rest_detector.check(self.state, bool(self.loop_closures))

    def read_state(self, body: int) -> Any:
        """Return the state of a body from SAPIEN."""
        part = self.parts[body]
        place = part.entity_pose
        return np.concatenate([place.p, place.q, part.linear_velocity, part.angular_velocity])

    def touching(self) -> set[tuple[int, int]]:
        """Return the pairs that touched in the last step; PhysX reports none beyond `TOUCH_BEGIN`."""
        met, numbers = set(), self.numbers
        for contact in self.system.get_contacts():
            if contact.points:
                one, other = contact.bodies
                first, second = numbers[one], numbers[other]
                met.add((first, second) if first < second else (second, first))
        if met != self.met:
            self.met = met
        return self.met


def entity(part: Any, number: int, place: Any) -> Any:
    """Return an entity with one part, named by the number of its body."""
    made = sapien.Entity()
    made.set_name(str(number))
    made.add_component(part)
    made.set_pose(frame(place))
    return made


def solve(part: Any, body: Rigid) -> None:
    """Set the dynamics of a body: PhysX's defaults damp spin; the loop damps jointed bodies."""
    linear, angular = (0.0, 0.0) if "Articulation" in type(part).__name__ else body.damping
    part.set_mass(body.mass)
    part.set_cmass_local_pose(sapien.Pose())
    part.set_inertia(np.array(body.moments, np.float32))
    part.set_linear_damping(linear)
    part.set_angular_damping(angular)
    part.set_max_angular_velocity(MAX_SPIN)
    part.set_max_depenetration_velocity(MAX_SEPARATION_SPEED)


def iterate(part: Any, velocity_iterations: int) -> None:
    """Set solver iterations: PhysX's defaults put bodies to sleep and iterate too little."""
    part.set_sleep_threshold(0.0)
    part.set_solver_position_iterations(POSITION_ITERATIONS)
    part.set_solver_velocity_iterations(velocity_iterations)
