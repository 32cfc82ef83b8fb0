"""Files for the fuzzer: datasets, traces, stages, assets, meshes and pictures, whole ones that were damaged.

A damaged file is cut off, has bits turned, parts swapped or doubled, says that something is longer than it is, or has
numbers and words that mean something else. Each is a pure function of its number.
"""

from __future__ import annotations

import hashlib
import io
import json
import random
import re
import shutil
import struct
import tempfile
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

from tests.dataset.made import make, plan
from wmspec.api.episode import load_episode, open_stage
from wmspec.check.task import check_program
from wmspec.diagnostics import Report, WmsError
from wmspec.execute import archive
from wmspec.gallery.gallery import folder as gallery_folder
from wmspec.lint.dry_run import dry_run
from wmspec.parse.load import load_source
from wmspec.places import Source
from wmspec.scene.model import Trace
from wmspec.usd import read
from wmspec.write.reader import DatasetReader

ROOT = Path(__file__).parent.parent
MESHES = ("obj", "stl", "ply", "off", "glb", "gltf", "dae")
KINDS = ("manifest", "shard", "trace", "stage", "usd", "urdf", "mjcf", "mesh", "picture")

SPEC = """use tabletop
task t : custom {{
  object thing {{ {what} }}
  observe front at 0 s
}}
"""
ODD = (
    b"nan",
    b"inf",
    b"-1",
    b"0",
    b"1e308",
    b"1e-308",
    b"999999999999999999999",
    b"",
    b"null",
    b"../../x",
    b"\xff\xfe",
)


@cache
def originals() -> Path:
    """A folder with a whole file of every kind."""
    made = Path(tempfile.mkdtemp(prefix="whole"))
    make(made / "dataset", plan(count=2), size=24)
    assets = ROOT / "tests/assets"
    shutil.copy(assets / "box.usda", made / "usd.usda")
    shutil.copy(assets / "pendulum.urdf", made / "urdf.urdf")
    shutil.copy(assets / "crane.xml", made / "mjcf.xml")
    shutil.copytree(assets / "parts", made / "parts")
    (made / "pictures").mkdir()
    Image.effect_noise((4, 4), 80).save(made / "pictures/four.png")
    shutil.copy(ROOT / "tests/stage/data/collide.usda", made / "stage.usda")
    open_stage(made / "stage.usda").Flatten().Export(str(made / "crate.usdc"))
    for kind in MESHES:
        trimesh.creation.icosphere(1, 0.05).export(str(made / f"mesh.{kind}"))
    picture = Image.effect_noise((24, 24), 80).convert("RGB")
    picture.save(made / "picture.png")
    picture.save(made / "picture.jpg")
    _trace(made / "trace.npz")
    return made


def _trace(path: Path) -> None:
    """A trace in which nothing happens."""
    stage = open_stage(originals_stage())
    scene = read(stage)
    t, n = round(scene.duration * scene.rate) + 1, len(scene.bodies)
    still = np.zeros((t, n, 3))
    here = np.stack([b.pose.position for b in scene.bodies])
    turn = np.stack([b.pose.orientation for b in scene.bodies])
    poses = np.broadcast_to(here, (t, n, 3)).copy(), np.broadcast_to(turn, (t, n, 4)).copy()
    names = tuple(b.name for b in scene.bodies)
    archive.save(stage, Trace("mujoco", names, np.arange(t) / scene.rate, *poses, still, still, ()), path)


def originals_stage() -> Path:
    """The stage that traces are of."""
    return ROOT / "tests/stage/data/collide.usda"


# ---------------------------------------------------------------- damage


def damaged(content: bytes, random_: random.Random) -> bytes:
    """The same with one to three damages."""
    for _ in range(random_.choice((1, 1, 1, 1, 2, 3))):
        content = random_.choices(_DAMAGES, _OFTEN)[0](content, random_)
    return content


def _cut(content: bytes, r: random.Random) -> bytes:
    return content[: r.randrange(len(content) + 1)]


def _flipped(content: bytes, r: random.Random) -> bytes:
    turned = bytearray(content)
    for _ in range(r.choice((1, 1, 1, 4))):
        if turned:
            turned[r.randrange(len(turned))] ^= 1 << r.randrange(8)
    return bytes(turned)


def _swapped(content: bytes, r: random.Random) -> bytes:
    a, b, c = sorted(r.randrange(len(content) + 1) for _ in range(3))
    return content[:a] + content[b:c] + content[a:b] + content[c:]


def _doubled(content: bytes, r: random.Random) -> bytes:
    a, b = sorted(r.randrange(len(content) + 1) for _ in range(2))
    return (content[:b] + content[a:b] * r.choice((1, 2, 9)) + content[b:])[:2_000_000]


def _lying(content: bytes, r: random.Random) -> bytes:
    """Somewhere it says a large number, as a length would be: 4 or 8 bytes of either order."""
    form, most = r.choice((("<I", 2**32), (">I", 2**32), ("<Q", 2**64), (">Q", 2**64)))
    number = struct.pack(form, r.choice((most - 1, most // 2, 2**31 - 1, 2**20, 0)))
    at = r.choice((r.randrange(len(content) + 1), r.randrange(min(200, len(content)) + 1)))
    return content[:at] + number + content[at + len(number) :]


def _reworded(content: bytes, r: random.Random) -> bytes:
    """A word or number of a text is another."""
    words = [m for m in _words(content) if m[1] > m[0]]
    if not words:
        return _flipped(content, r)
    a, b = r.choice(words)
    c, d = r.choice(words)
    return content[:a] + r.choice((*ODD, content[c:d])) + content[b:]


def _words(content: bytes) -> list[tuple[int, int]]:
    return [m.span() for m in re.finditer(rb"[\w.+-]+", content[:200_000])]


_DAMAGES: tuple[Callable[[bytes, random.Random], bytes], ...] = (_cut, _flipped, _swapped, _doubled, _lying, _reworded)
_OFTEN = (1, 4, 1, 1, 4, 5)


# ---------------------------------------------------------------- trying


def attempt_file(number: int) -> str:
    """Damage a file and read it as wmspec would; returns how far it came, or raises whatever is a defect of ours.

    Its folder has others around it, so that what is written outside is seen.
    """
    kind, random_ = KINDS[number % len(KINDS)], random.Random(f"file {number}")  # noqa: S311
    with tempfile.TemporaryDirectory(prefix="fuzz") as root:
        home = Path(root) / "a" / "b" / "c"
        home.mkdir(parents=True)
        try:
            _TRY[kind](home, random_)
            came = "read"
        except WmsError as error:
            error.render()
            came = "refused"
        outside = [p for p in Path(root).rglob("*") if p.is_file() and not p.is_relative_to(home)]
        assert not outside, f"written outside: {outside}"
    return f"{kind} {came}"


def _dataset(home: Path, name: str, r: random.Random, signed: bool) -> None:
    folder = home / "dataset"
    shutil.copytree(originals() / "dataset", folder)
    path = folder / name
    path.write_bytes(damaged(path.read_bytes(), r))
    if signed:
        place = folder / "manifest.json"
        manifest = json.loads(place.read_bytes())
        manifest["shards"][name]["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
        place.write_text(json.dumps(manifest))
    gallery_folder(DatasetReader.open(folder), 2, home / "out")


def _shard(home: Path, r: random.Random) -> None:
    shards = sorted((originals() / "dataset").glob("data/*/*.parquet"))
    _dataset(home, str(r.choice(shards).relative_to(originals() / "dataset")), r, signed=True)


def _of_trace(home: Path, r: random.Random) -> None:
    path = home / "trace.npz"
    if r.random() < 0.4:
        path.write_bytes(damaged((originals() / "trace.npz").read_bytes(), r))
    else:  # an archive that is whole, of arrays that are not
        with np.load(originals() / "trace.npz") as file:
            members = {name: _saved(file[name]) for name in file.files}
        name = r.choice(sorted(members))
        members[name] = damaged(members[name], r)
        with zipfile.ZipFile(path, "w") as archived:
            for each, content in members.items():
                archived.writestr(f"{each}.npy", content)
    load_episode(path)


def _saved(array: np.ndarray) -> bytes:
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()


def _stage(home: Path, r: random.Random) -> None:
    name = r.choice(("stage.usda", "crate.usdc"))
    (home / name).write_bytes(damaged((originals() / name).read_bytes(), r))
    read(open_stage(home / name))


def _checked(home: Path, what: str) -> None:
    report = Report()
    program = load_source(Source(str(home / "t.wms"), SPEC.format(what=what)), home, report)
    for spec in check_program(program, report):
        dry_run(spec, report)
    report.stop_if_failed()


def _asset(name: str) -> Callable[[Path, random.Random], None]:
    def attempt(home: Path, r: random.Random) -> None:
        for beside in ("parts", "pictures"):
            shutil.copytree(originals() / beside, home / beside)
        (home / name).write_bytes(damaged((originals() / name).read_bytes(), r))
        _checked(home, f'file: "{name}"')

    return attempt


def _mesh(home: Path, r: random.Random) -> None:
    _asset(f"mesh.{r.choice(MESHES)}")(home, r)


def _picture(home: Path, r: random.Random) -> None:
    name = r.choice(("picture.png", "picture.jpg"))
    (home / name).write_bytes(damaged((originals() / name).read_bytes(), r))
    _checked(home, f'shape: cube  size: 5 cm  image: "{name}"')


_TRY: dict[str, Callable[[Path, random.Random], None]] = {
    "manifest": lambda home, r: _dataset(home, "manifest.json", r, signed=False),
    "shard": _shard,
    "trace": _of_trace,
    "stage": _stage,
    "usd": _asset("usd.usda"),
    "urdf": _asset("urdf.urdf"),
    "mjcf": _asset("mjcf.xml"),
    "mesh": _mesh,
    "picture": _picture,
}
