"""Descriptions of arms in TOML: a file with links and hinges, and a hand attached to one of them."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from wmspec.compile.robots.arm import MAX_PAD_LENGTH, Arm, Array, axis_rotation, translation
from wmspec.core.diagnostics import Diagnostic, WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_text
from wmspec.lang.importers.model import Asset, Joint, Shape
from wmspec.lang.importers.read import structure
from wmspec.sim.scene.model import Pose
from wmspec.sim.scene.model.transform import compose, inverse, quaternion, rotation

Triple = tuple[float, float, float]
Above0 = Annotated[float, Field(gt=0)]
MAX_HINGES = 12  # of an arm


class Hand(BaseModel):
    """A hand of two fingers that open along its y; z is ahead. Lengths in m, angles in degrees.

    Its frame is `at`, rotated by `turn` about x, then y, then z, in the frame of the link `on`. The `palm` is a box
    from there ahead. The `fingers` are boxes from its end ahead. Sizes are along x, y and z. `opening` is the maximum
    distance of the fingers, `grip` (N) their force and `rubber` their friction.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)
    on: str
    at: Triple = (0.0, 0.0, 0.0)
    turn: Triple = (0.0, 0.0, 0.0)
    palm: tuple[Above0, Above0, Above0]
    fingers: tuple[Above0, Above0, Above0]
    opening: Above0
    grip: Above0
    rubber: Above0 = 1.0


class Description(BaseModel):
    """A `file` (URDF, MJCF, USD), relative to the description or to an installed Python `package`, with additions.

    `rest` is the configuration between actions, with the hand retracted and looking down. `home` is the preferred
    configuration for redundant joints; both in degrees. `speed` limits the joints, in degrees per second.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)
    file: str
    package: str = ""
    rest: tuple[float, ...]
    home: tuple[float, ...] = ()
    speed: tuple[Above0, ...] = (90.0,)
    hand: Hand


@dataclass(frozen=True, eq=False)
class ArmModel:
    """An arm, and the visual geometry of each link in its own frame, the base first; meshes are below `folder`.

    `ignored` are warnings of its file that do not matter for kinematic bodies.
    """

    arm: Arm
    shapes: tuple[tuple[tuple[Shape, Pose], ...], ...]
    folder: Path
    ignored: tuple[Diagnostic, ...]


def read_description(path: Path) -> ArmModel:
    """Return the arm that a TOML file describes. Raises WmsError for invalid descriptions."""
    said = _read_toml(path)
    folder = path.parent if not said.package else _package_folder(said.package, path)
    asset, ignored = structure(folder, said.file)
    places, chain = _chain(asset, said.hand.on, path)
    if not 0 < len(chain) <= MAX_HINGES:
        raise WmsError(
            f"{len(chain)} hinges lead to `{said.hand.on}`",
            FilePlace(str(path)),
            f"name a link behind 1 to {MAX_HINGES}",
        )
    for name, given in (("rest", said.rest), ("home", said.home or said.rest), ("speed", said.speed)):
        if len(given) != len(chain) and not (name == "speed" and len(given) == 1):
            what = f"`{name}` has {len(given)} numbers, and {len(chain)} hinges lead to `{said.hand.on}`"
            raise WmsError(what, FilePlace(str(path)), f"write {len(chain)}")
    frames = [np.eye(4), *(_hinge(places, joint) for joint in chain)]
    shapes: list[list[tuple[Shape, Pose]]] = [[] for _ in frames]
    for name, link in asset.links.items():
        owner = _moving_link(asset, chain, name)
        if owner is not None:
            own = inverse(_pose(frames[owner]))
            shapes[owner] += [(s, compose(own, compose(places[name], s.pose))) for s in link.shapes if s.drawn]
    return ArmModel(_arm(said, chain, frames, places[said.hand.on]), tuple(map(tuple, shapes)), folder, ignored)


def _read_toml(path: Path) -> Description:
    try:
        return Description.model_validate(tomllib.loads(read_text(path)))
    except (OSError, UnicodeDecodeError) as error:
        raise WmsError(f"cannot be read: {error}", FilePlace(str(path))) from None
    except tomllib.TOMLDecodeError as error:
        raise WmsError(f"is no TOML: {error}", FilePlace(str(path))) from None
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise WmsError(f"`{where}`: {first['msg']}", FilePlace(str(path)), "see docs/robots.md") from None


def _package_folder(name: str, path: Path) -> Path:
    """Return the folder of an installed package without importing it."""
    known = find_spec(name) if name.isidentifier() else None
    if known is None or not known.submodule_search_locations:
        raise WmsError(f"there is no package `{name[:60]}`", FilePlace(str(path)), f"pip install {name}")
    return Path(known.submodule_search_locations[0])


def _chain(asset: Asset, end: str, path: Path) -> tuple[dict[str, Pose], list[Joint]]:
    """Return the poses of all links with joints at 0, and the hinges from the base to a link, in order."""
    held = {joint.child: joint for joint in asset.joints.values() if joint.kind != "free"}
    if end not in asset.links:
        raise WmsError(f"there is no link `{end[:60]}`", FilePlace(str(path)), f"its links: {', '.join(asset.links)}")
    places: dict[str, Pose] = {}

    def place(name: str, above: int = 0) -> Pose:
        if above > len(asset.links):
            raise WmsError("its links hold each other in a circle", FilePlace(str(path)))
        if name not in places:
            joint = held.get(name)
            here = Pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
            places[name] = compose(place(joint.parent, above + 1), joint.place) if joint else here
        return places[name]

    for name in asset.links:
        place(name)
    chain, name = list[Joint](), end
    while name in held:
        chain.insert(0, held[name])
        name = held[name].parent
    if wrong := next((joint for joint in chain if joint.kind not in ("hinge", "fixed")), None):
        raise WmsError(f"`{wrong.name}` is a {wrong.kind} joint; arms have hinges only", FilePlace(str(path)))
    return places, [joint for joint in chain if joint.kind == "hinge"]


def _hinge(places: dict[str, Pose], joint: Joint) -> Array:
    """Return the frame (4, 4) of a hinge with joints at 0; it turns about its z."""
    here = _matrix(places[joint.child])
    z = joint.axis / np.linalg.norm(joint.axis)
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    x /= np.linalg.norm(x)
    own = np.eye(4)
    own[:3, :3], own[:3, 3] = np.column_stack([x, np.cross(z, x), z]), joint.at
    return np.asarray(here @ own)


def _moving_link(asset: Asset, chain: list[Joint], name: str) -> int | None:
    """Return the index of the moving link that a link is fixed to (0 is the base), or None if it moves itself."""
    held = {joint.child: joint for joint in asset.joints.values()}
    numbers = {joint.name: i for i, joint in enumerate(chain, 1)}
    while name in held:
        joint = held[name]
        if joint.name in numbers:
            return numbers[joint.name]
        if joint.kind != "fixed":
            return None
        name = joint.parent
    return 0


def _arm(said: Description, chain: list[Joint], frames: list[Array], on: Pose) -> Arm:
    hand, n = said.hand, len(chain)
    (width, broad, deep), (thick_x, thick_y, long) = hand.palm, hand.fingers
    roll, pitch, yaw = np.radians(hand.turn)
    mount = translation(*hand.at) @ axis_rotation(2, yaw) @ axis_rotation(1, pitch) @ axis_rotation(0, roll)
    reach = deep + long - min(MAX_PAD_LENGTH, long) / 2
    degrees = [np.array(numbers) for numbers in (said.rest, said.home or said.rest)]
    return Arm(
        frames=np.array([np.linalg.inv(a) @ b for a, b in pairwise(frames)]),
        hand=np.linalg.inv(frames[-1]) @ _matrix(on) @ mount,
        reach=reach,
        finger=deep,
        low=np.array([-2 * np.pi if joint.low is None else joint.low for joint in chain]),
        high=np.array([2 * np.pi if joint.high is None else joint.high for joint in chain]),
        speed=np.radians(np.broadcast_to(np.array(said.speed), (n,))),
        home=np.radians(degrees[1]),
        rest=np.radians(degrees[0]),
        hull=np.array([[-width / 2, -broad / 2, 0.0], [width / 2, broad / 2, deep]]),
        tip=np.array([[-thick_x / 2, 0.0, 0.0], [thick_x / 2, thick_y, long]]),
        opening=hand.opening,
        palm=reach - deep,
        pad=thick_y,
        width=thick_x,
        grip=hand.grip,
        rubber=hand.rubber,
        asset="",
        joints=(*(f"joint{i}" for i in range(1, n + 1)), "left_slide", "right_slide"),
    )


def _matrix(pose: Pose) -> Array:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = rotation(pose.orientation), pose.position
    return made


def _pose(frame: Array) -> Pose:
    return Pose(frame[:3, 3], quaternion(frame[:3, :3]))
