"""Public files that `tools.native_files` compares with their native loaders."""

from __future__ import annotations

from typing import NamedTuple


class File(NamedTuple):
    """A file of a package; `note` says why it differs, where what is reported does not.

    The base of a URDF is `held` in the air, or the file stands on a ground. Its hinges start at `turn` (rad).
    """

    name: str
    package: str
    path: str
    held: bool = True
    note: str = ""
    turn: float = 0.1

    @property
    def key(self) -> str:
        """The key of its results."""
        return f"{self.package}/{self.path}"


_BULLET, _GYM, _ROBOTS = "pybullet_data", "gymnasium/envs/mujoco/assets", "gymnasium_robotics/envs/assets"
_DATA = "cmeel.prefix/share/example-robot-data/robots"
_GENESIS = "genesis/assets"

_ONE_KILOGRAM = (
    "PyBullet gives each link without `inertial` a mass of 1 kg; wmspec computes its mass from its shapes and density"
)
_CONTINUOUS = "nothing moves; PyBullet applies the `limit` of a `continuous` joint, and wmspec does not"

FILES = (
    # arms
    File("Panda", "pybullet", f"{_BULLET}/franka_panda/panda.urdf"),
    File("KUKA iiwa", "pybullet", f"{_BULLET}/kuka_iiwa/model.urdf"),
    File("UR5", "example-robot-data", f"{_DATA}/ur_description/urdf/ur5_robot.urdf"),
    File("xArm 6", "pybullet", f"{_BULLET}/xarm/xarm6_robot.urdf"),
    File("UR3e", "airo-models", "airo_models/arms/ur3e/ur3e.urdf", note=_ONE_KILOGRAM),
    File("UR10", "example-robot-data", f"{_DATA}/ur_description/urdf/ur10_robot.urdf"),
    File("Fetch, reach", "gymnasium-robotics", f"{_ROBOTS}/fetch/reach.xml"),
    File("Pusher", "gymnasium", f"{_GYM}/pusher_v5.xml"),
    File("Reacher", "gymnasium", f"{_GYM}/reacher.xml"),
    File("Panda, Menagerie", "genesis-world", f"{_GENESIS}/xml/franka_emika_panda/panda.xml"),
    File("ALOHA", "gym-aloha", "gym_aloha/assets/bimanual_viperx_transfer_cube.xml"),
    # legs, wheels
    File("A1", "pybullet", f"{_BULLET}/a1/a1.urdf"),
    File("Laikago", "pybullet", f"{_BULLET}/laikago/laikago_toes.urdf"),
    File("ANYmal C", "genesis-world", f"{_GENESIS}/urdf/anymal_c/urdf/anymal_c.urdf", note=_ONE_KILOGRAM),
    File("Husky", "pybullet", f"{_BULLET}/husky/husky.urdf", note=_ONE_KILOGRAM),
    File("R2-D2", "pybullet", f"{_BULLET}/r2d2.urdf", note=_CONTINUOUS),
    File("Ant", "gymnasium", f"{_GYM}/ant.xml"),
    File("Ant, Newton", "newton", "newton/examples/assets/nv_ant.xml"),
    File("Hopper", "gymnasium", f"{_GYM}/hopper.xml"),
    File("Half-cheetah", "gymnasium", f"{_GYM}/half_cheetah.xml"),
    File("Walker2d", "gymnasium", f"{_GYM}/walker2d_v5.xml"),
    File("Walker, dm_control", "dm-control", "dm_control/suite/walker.xml"),
    # humanoids, hands
    File("Humanoid", "gymnasium", f"{_GYM}/humanoid.xml", turn=0.0),  # its turned legs would overlap
    File("Humanoid, Bullet", "pybullet", f"{_BULLET}/humanoid/humanoid.urdf"),
    File("Shadow Hand", "gymnasium-robotics", f"{_ROBOTS}/hand/reach.xml"),
    File("Shadow Hand, URDF", "genesis-world", f"{_GENESIS}/urdf/shadow_hand/shadow_hand.urdf", note=_ONE_KILOGRAM),
    # poles, pendulums
    File("Cart-pole", "pybullet", f"{_BULLET}/cartpole.urdf"),
    File("Cart-pole, dm_control", "dm-control", "dm_control/suite/cartpole.xml"),
    File("Inverted double pendulum", "gymnasium", f"{_GYM}/inverted_double_pendulum.xml"),
    File("Acrobot", "dm-control", "dm_control/suite/acrobot.xml"),
    File("Pendulum of five", "pybullet", f"{_BULLET}/pendulum5.urdf"),
    # objects
    File("Duck", "pybullet", f"{_BULLET}/duck_vhacd.urdf", held=False),
    File("Table", "pybullet", f"{_BULLET}/table/table.urdf", held=False),
    File("Domino", "pybullet", f"{_BULLET}/domino/domino.urdf", held=False),
    File("Jenga block", "pybullet", f"{_BULLET}/jenga/jenga.urdf", held=False),
    File("Lego brick", "pybullet", f"{_BULLET}/lego/lego.urdf", held=False),
    File("Bottle, PartNet 3763", "genesis-world", f"{_GENESIS}/urdf/3763/mobility_vhacd.urdf", note=_ONE_KILOGRAM),
    File("Bottle, PartNet 3763, original", "genesis-world", f"{_GENESIS}/urdf/3763/mobility.urdf", note=_ONE_KILOGRAM),
)
