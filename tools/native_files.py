"""Compare public files in wmspec with their native loaders, and write docs/benchmarks/native_files.md.

python -m tools.native_files run FOLDER     FOLDER as `tools.public_files fetch` fills it; results in FOLDER/native.json
python -m tools.native_files table FOLDER   rewrites the page from the results

MuJoCo loads MJCF, and PyBullet loads URDF. Compared are the masses of all links, the limits of all joints, and the
centre of mass of each link that can move during one second. All controls are 0, and the motors that PyBullet adds to
joints are off, as are its dampers of links. Inertias are those of the files, also impossible ones.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tools.native_models import FILES, File
from tools.reference import table
from wmspec.api.asset_task import plane_height
from wmspec.api.loading import TextCheck
from wmspec.api.task import Task
from wmspec.core.diagnostics import WmsError
from wmspec.lang.importers.blocks import relevant_faults, to_identifier
from wmspec.lang.importers.model import Joint, RejectedAsset
from wmspec.lang.importers.read import read
from wmspec.lang.importers.tree import LinkTree
from wmspec.runtime.engines.registry import info
from wmspec.sim.scene.model import Array, Body
from wmspec.sim.scene.model.transform import rotate

PAGE = Path(__file__).parent.parent / "docs/benchmarks/native_files.md"
START, STOP = "<!-- files -->\n", "<!-- /files -->\n"
ENGINES = ("mujoco", "pybullet", "sapien")
SECONDS = 1.0
#: Steps of PyBullet a second.
RATE = 1000
#: What is reported where inertias of the file cannot be used.
SHAPES = "one inertia is impossible: all are those of the shapes"
#: Divisor of the time step of a second execution, which shows how exact the first one is.
FINER = 4
_SPEC = """task native : custom {{
{ground}  object it {{ file: "{file}"  inertia: file  {place}
{parts}
  }}
  horizon 1 s
  camera front {{ at: (2 m, -3 m, 1.5 m)  look_at: (0, 0, 40 cm) }}
  observe front at [0 s]
}}
"""
_GROUND = (
    "  object floor_ {{ shape: box  size: (40 m, 40 m, 10 cm)  at: (0, 0, {:.9g} m)  fixed: true  friction: {} }}\n"
)
#: Friction of PyBullet's bodies without one.
_FRICTION = 0.5


class Native(NamedTuple):
    """What a native loader makes of a file: masses (kg) of links, limits of joints, and motion.

    `paths` are the centres of mass (m), (T, 3) for each link, at the `times` (T,) s.
    """

    masses: dict[str, float]
    limits: dict[str, tuple[float, float] | None]
    times: Array
    paths: dict[str, Array]


def in_mujoco(path: Path, _: bool, starts: dict[str, float], finer: int) -> Native:
    """Load and execute an MJCF with 1 / `finer` of its own time step, its joints at `starts` (rad, m)."""
    import mujoco

    m = mujoco.MjModel.from_xml_path(str(path))
    sliding = int(mujoco.mjtJoint.mjJNT_SLIDE)  # or turning; smaller ones are free and ball joints
    data = mujoco.MjData(m)
    m.opt.timestep /= finer
    limits: dict[str, tuple[float, float] | None] = {}
    for j in (j for j in range(m.njnt) if m.jnt_type[j] >= sliding):
        name, at = _joint_name(m, j), int(m.jnt_qposadr[j])
        data.qpos[at] = m.qpos0[at] + starts.get(name, 0.0)
        low, high = (float(x - m.qpos0[at]) for x in m.jnt_range[j])
        limits[name] = (low, high) if m.jnt_limited[j] else None
    mujoco.mj_forward(m, data)
    times, places = [0.0], [data.xipos.copy()]
    while data.time < SECONDS:
        mujoco.mj_step(m, data)
        mujoco.mj_kinematics(m, data)
        mujoco.mj_comPos(m, data)
        times.append(float(data.time))
        places.append(data.xipos.copy())
    names = [m.body(i).name or f"body_{i}" for i in range(m.nbody)]
    paths = {names[i]: np.array([p[i] for p in places]) for i in range(1, m.nbody)}
    return Native({names[i]: float(m.body_mass[i]) for i in range(1, m.nbody)}, limits, np.array(times), paths)


def _joint_name(m: Any, j: int) -> str:
    """Return the name of a joint, or the one that wmspec gives it."""
    body, first = m.body(m.jnt_bodyid[j]), int(m.body_jntadr[m.jnt_bodyid[j]])
    return m.joint(j).name or (f"{body.name} joint" if j == first else f"{body.name} joint_{j - first + 1}")


def in_pybullet(path: Path, held: bool, starts: dict[str, float], finer: int) -> Native:
    """Load and execute a URDF, its base `held` or on a ground, its joints at `starts` (rad, m)."""
    import pybullet as p

    p.connect(p.DIRECT)
    try:
        flags = p.URDF_USE_INERTIA_FROM_FILE
        free = p.loadURDF(str(path), flags=flags)
        names = {-1: p.getBodyInfo(free)[0].decode()}
        names |= {j: p.getJointInfo(free, j)[12].decode() for j in range(p.getNumJoints(free))}
        masses = {name: float(p.getDynamicsInfo(free, i)[0]) for i, name in names.items()}
        p.removeBody(free)
        it = p.loadURDF(str(path), useFixedBase=held, flags=flags)
        if not held:
            low = min(p.getAABB(it, i)[0][2] for i in names)
            _stand(p, it, low)
        limits: dict[str, tuple[float, float] | None] = {}
        for j in range(p.getNumJoints(it)):
            info = p.getJointInfo(it, j)
            if info[2] in (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC):
                own = (float(info[8]), float(info[9]))
                limits[info[1].decode()] = own if own[0] < own[1] else None
                p.resetJointState(it, j, starts.get(info[1].decode(), 0.0))
                p.setJointMotorControl2(it, j, p.VELOCITY_CONTROL, force=0)
            elif info[2] == p.JOINT_SPHERICAL:
                p.setJointMotorControlMultiDof(it, j, p.POSITION_CONTROL, [0, 0, 0, 1], force=[0, 0, 0])
        for i in names:
            p.changeDynamics(it, i, linearDamping=0, angularDamping=0)
        p.setGravity(0, 0, -9.81)
        p.setTimeStep(1 / (RATE * finer))
        steps = int(SECONDS * RATE)
        places = [_centers(p, it, names)]
        for _ in range(steps):
            for _ in range(finer):
                p.stepSimulation()
            places.append(_centers(p, it, names))
        times = np.linspace(0, SECONDS, steps + 1)
        return Native(masses, limits, times, {name: np.array([at[name] for at in places]) for name in names.values()})
    finally:
        p.disconnect()


def _stand(p: Any, it: int, low: float) -> None:
    """Put a body whose lowest point is at `low` on a ground."""
    box = p.createCollisionShape(p.GEOM_BOX, halfExtents=[20, 20, 0.05])
    ground = p.createMultiBody(0, box, basePosition=[0, 0, -0.05])
    p.changeDynamics(ground, -1, lateralFriction=_FRICTION)
    at, turn = p.getBasePositionAndOrientation(it)
    p.resetBasePositionAndOrientation(it, [at[0], at[1], at[2] - low], turn)


def _centers(p: Any, it: int, names: dict[int, str]) -> dict[str, Any]:
    """Return the centres of mass of all links."""
    states = {i: p.getLinkState(it, i, computeForwardKinematics=1)[0] for i in names if i >= 0}
    return {names[-1]: p.getBasePositionAndOrientation(it)[0], **{names[i]: at for i, at in states.items()}}


# ---------------------------------------------------------------- wmspec


def compared(folder: Path, file: File) -> dict[str, Any]:
    """Return the comparison of one file."""
    path = folder / file.package / file.path
    mjcf = path.suffix == ".xml"
    load: Callable[[Path, bool, dict[str, float], int], Native] = in_mujoco if mjcf else in_pybullet
    tree = read(folder / file.package, file.path)
    if isinstance(tree, RejectedAsset):
        return {"refused": relevant_faults(tree, {}, ())[0].message}
    starts = {joint.name: _start(joint, file.turn) for joint in tree.joints if joint.kind in ("hinge", "slider")}
    starts |= {name.removesuffix("_joint"): start for name, start in starts.items()}  # as the file names them
    try:
        native, finer = (load(path, file.held, starts, steps) for steps in (1, FINER))
    except ValueError as error:  # such as a picture that was not fetched
        return {"refused": f"MuJoCo: {str(error).replace(str(folder), '').partition(chr(10))[0]}"}
    height = plane_height(path.read_bytes()) if mjcf else None if file.held else 0.0
    named = {joint.name: "rad" if joint.kind == "hinge" else "m" for joint in tree.joints}
    parts = [f"part {to_identifier(n)} {{ start: {starts[n]:.9g} {named[n]} }}" for n in named if n in starts]
    if not mjcf:
        parts += _passing(tree)
    place = "at: (0, 0, 0)" if mjcf or file.held else "on: floor_ at (0, 0)"
    text = _SPEC.format(
        ground="" if height is None else _GROUND.format(height - 0.05, 1 if mjcf else _FRICTION),
        file=file.path,
        place=place + ("  fixed: true" if file.held and not mjcf else ""),
        parts="\n".join(f"    {part}" for part in parts),
    )
    found = _task(text, folder / file.package / "native.wms")
    if isinstance(found, str):
        return {"refused": found}
    task, given = found
    made: dict[str, Any] = {
        "reported": [*([] if given else [SHAPES]), *(d.message for d in relevant_faults(tree, {}, ()))],
        "native mass": sum(native.masses.values()),
        "moves": _most({name: p - p[0] for name, p in native.paths.items()}),
        "finer": _most({n: _at(finer, n, native.times) - p for n, p in native.paths.items()}),
    }
    for engine in ENGINES:
        try:
            episode = task[0].run(engine)
        except WmsError as error:
            made[engine] = str(error)
            continue
        bodies = {body.name: body for body in episode.scene.bodies}
        own = {name: body for name in native.paths if (body := bodies.get(_ours(tree, name))) and body.inertia}
        moving = {name: body for name, body in own.items() if body.motion == "dynamic"}
        made |= {"mass": _mass(tree, bodies), "links": len(moving), "limits": _limits(native, episode.scene.joints)}
        off = {}
        for name, body in moving.items():
            track = episode[body.name]
            centers = track.position + np.array([rotate(q, _center(body)) for q in track.orientation])
            off[name] = centers - _at(native, name, episode.time)
        if not mjcf and not file.held:  # the ground is where each puts it
            off = {name: o - o[0] for name, o in off.items()}
        made["start"] = _most({name: o[:1] for name, o in off.items()})
        made[engine] = _most(off)
    return made


def _task(text: str, path: Path) -> tuple[Task, bool] | str:
    """Return the task of a spec and whether its inertias are those of the file, or why there is none.

    Where no body can have one of the inertias, all of them are those of the shapes.
    """
    for one in (text, text.replace("inertia: file", "")):
        check = TextCheck(one, path)
        errors = [d.message for d in check.diagnosis().diagnostics if d.severity == "error" and d.code != "WMS601"]
        if check.tasks and not errors:
            return check.tasks[0], one is text
    return errors[0] if errors else "no task"


def _start(joint: Joint, turn: float) -> float:
    """Return where a joint starts (rad, m): hinges are turned by `turn`, so that nothing is balanced."""
    low, high = (-np.inf if joint.low is None else joint.low), (np.inf if joint.high is None else joint.high)
    return float(np.clip(turn if joint.kind == "hinge" else 0.0, low, high))


def _passing(tree: LinkTree) -> list[str]:
    """Return parts of a spec that let the links pass each other, as PyBullet does by default."""
    _, *others = [to_identifier(placed.link.name) for placed in tree.links]
    every = [f"it.{name}" for name in others]
    parts = [f"passes: [{', '.join(every)}]"] if every else []
    later = ((name, every[i + 1 :]) for i, name in enumerate(others[:-1]))
    return parts + [f"part {name} {{ passes: [{', '.join(names)}] }}" for name, names in later]


def _ours(tree: LinkTree, name: str) -> str:
    """Return the name of a link in the scene."""
    return "it" if tree.links[0].link.name == name else f"it_{to_identifier(name)}"


def _center(body: Body) -> Array:
    assert body.inertia is not None
    return body.inertia.center


def _mass(tree: LinkTree, bodies: dict[str, Body]) -> float:
    """Return the mass of all links (kg): that of the file, or that of the density."""
    own = ((placed.link.mass, bodies.get(_ours(tree, placed.link.name))) for placed in tree.links)
    return sum(m.mass if m is not None else (body.mass or 0.0) if body is not None else 0.0 for m, body in own)


def _limits(native: Native, joints: Any) -> list[str]:
    """Return the joints whose limits differ."""
    ours = {joint.name: joint.limits for joint in joints}
    found = []
    for name, limits in native.limits.items():
        plain = f"it_{to_identifier(name)}"
        own = ours[f"{plain}_joint"] if f"{plain}_joint" in ours else ours.get(plain, limits)
        if (own is None) != (limits is None) or (own and limits and not np.allclose(own, limits, atol=1e-4)):
            found.append(name)
    return found


def _at(native: Native, name: str, times: Array) -> Array:
    """Return the path of a link at other times."""
    path = native.paths[name]
    return np.stack([np.interp(times, native.times, path[:, k]) for k in range(3)], axis=1)


def _most(offsets: dict[str, Array]) -> float:
    """Return the largest distance (mm)."""
    return max((1e3 * float(np.linalg.norm(o, axis=1).max()) for o in offsets.values()), default=0.0)


# ---------------------------------------------------------------- page


def page(results: dict[str, Any]) -> str:
    """Return the table of all files."""
    rows = []
    for file in FILES:
        found = results.get(file.key)
        if found is None:
            continue
        name = f"{file.name} (`{file.package}/{Path(file.path).name}`)"
        if "mass" not in found:  # no engine executes it
            why = found.get("refused") or found[ENGINES[0]].partition("\n")[0].removeprefix("/World/Joints/it_")
            rows.append((name, *([""] * 4), *(["refused"] * len(ENGINES)), why[:140]))
            continue
        mass = _pair(found["native mass"], found["mass"])
        engines = [_millimetres(found.get(e)) for e in ENGINES]
        limits = "equal" if not found["limits"] else f"{len(found['limits'])} differ"
        own = [_millimetres(found[k]) for k in ("moves", "finer")]
        rows.append((name, mass, limits, *own, *engines, file.note or _kinds(found["reported"])))
    head = (
        "file",
        "mass (kg)",
        "limits",
        "moves",
        "finer steps",
        *(info(engine).title for engine in ENGINES),
        "reason or warnings",
    )
    return "\n".join(table(head, rows))


def _pair(native: float, ours: float) -> str:
    same = abs(native - ours) <= 1e-3 * max(native, 1e-9)
    return f"{ours:.4g}" if same else f"{native:.4g}, wmspec {ours:.4g}"


def _millimetres(of: Any) -> str:
    return f"{of:.1f}" if isinstance(of, float) else "refused" if of else ""


def _kinds(reported: list[str]) -> str:
    """Return what is reported, briefly."""
    said = [re.sub(r"^\S+:\d+: (`[^`]*`: )?", "", text).partition(": ")[0] for text in reported]
    return "; ".join(dict.fromkeys(re.sub(r" (is|are) not supported", "", text) for text in said))


def main() -> None:
    """Run one step."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("step", choices=["run", "table"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", default="", help="files whose name contains this text")
    chosen = parser.parse_args()
    store = chosen.folder / "native.json"
    results: dict[str, Any] = json.loads(store.read_text()) if store.exists() else {}
    if chosen.step == "run":
        for file in FILES:
            if chosen.only in file.name and (chosen.only or file.key not in results):
                results[file.key] = compared(chosen.folder, file)
                store.write_text(json.dumps(results, indent=1))
                print(file.name, results[file.key], flush=True)
        return
    before, _, rest = PAGE.read_text().partition(START)
    PAGE.write_text(f"{before}{START}\n{page(results)}\n\n{STOP}{rest.partition(STOP)[2]}")


if __name__ == "__main__":
    main()
