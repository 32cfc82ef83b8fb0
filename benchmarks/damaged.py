"""Damaged files for the fuzzer: datasets, traces, stages, assets, meshes and pictures.

A damaged file is truncated, or has flipped bits, swapped or repeated parts, false lengths, or changed numbers and
words. Most of these are unreadable, so there are also readable files with changed values and lines. Each file is a pure
function of its number.
"""

from __future__ import annotations

import io
import math
import random
import re
import shutil
import struct
import tempfile
import warnings
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from tests.dataset.made import make, plan
from tests.trust.made import resaved, rewritten, signed, wmspec
from wmspec.api.episode import load_episode, open_stage, run
from wmspec.api.loading import load
from wmspec.compile.lint.dry_run import dry_run
from wmspec.core.diagnostics import Report, WmsError
from wmspec.core.places import Source
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.gallery.gallery import folder as gallery_folder
from wmspec.eval.image_import.importer import import_images
from wmspec.eval.models import results
from wmspec.eval.report import replies
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.parse.load import load_source
from wmspec.runtime.engines import archive
from wmspec.sim.scene.model import Trace
from wmspec.sim.usd import read

ROOT = Path(__file__).parent.parent
MESHES = ("obj", "stl", "ply", "off", "glb", "gltf", "dae")
TEXTS = ("obj", "off", "gltf", "dae")

Damage = Callable[[bytes, random.Random], bytes]
Attempt = Callable[[Path, random.Random, Damage], None]
KINDS = ("manifest", "shard", "trace", "stage", "usd", "urdf", "mjcf", "mesh", "picture")
CHANGED = ("manifest", "rows", "arrays", "stage", "usd", "urdf", "mjcf", "mesh", "results", "table")

SPEC = """use tabletop
task t : custom {{
  object thing {{ {what} }}
  observe front at 0 s
}}
"""
TABLE = b"""question,pictures,options,answer,frames,times,difference,quantity,within,factor.kind
"Which is it?","a.png;b.jpg","left;right","left","","0;1.5","2.5","size","","near"
"How far, in ""m""?","b.jpg","","3","","","","","0.5","far"
"Which one?","a.png","a.png;b.jpg","b.jpg","","","","","","near"
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
    """Return a folder with a valid file of every kind."""
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
    moving = load(ROOT / "specs/prediction/mechanistic/collide.wms")[0].stage()
    moving.Flatten().Export(str(made / "executed.usda"))
    open_stage(made / "stage.usda").Flatten().Export(str(made / "crate.usdc"))
    for kind in MESHES:
        trimesh.creation.icosphere(1, 0.05).export(str(made / f"mesh.{kind}"))
    picture = Image.effect_noise((24, 24), 80).convert("RGB")
    picture.save(made / "picture.png")
    picture.save(made / "picture.jpg")
    _trace(made / "trace.npz")
    (made / "photos").mkdir()
    for name in ("a.png", "b.jpg"):
        picture.rotate(90 * (name == "a.png")).save(made / "photos" / name)
    evaluated = wmspec("evaluate", made / "dataset", "-m", "random", "-o", made / "results.parquet")
    assert evaluated.exit_code == 0, evaluated.output
    return made


def _trace(path: Path) -> None:
    """Write a trace without motion."""
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
    """Return the stage of the traces."""
    return ROOT / "tests/stage/data/collide.usda"


# ---------------------------------------------------------------- damage


def damaged(content: bytes, random_: random.Random) -> bytes:
    """Return the content with one to three damages."""
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
    """Insert a large number like a length: 4 or 8 bytes of either order."""
    form, most = r.choice((("<I", 2**32), (">I", 2**32), ("<Q", 2**64), (">Q", 2**64)))
    number = struct.pack(form, r.choice((most - 1, most // 2, 2**31 - 1, 2**20, 0)))
    at = r.choice((r.randrange(len(content) + 1), r.randrange(min(200, len(content)) + 1)))
    return content[:at] + number + content[at + len(number) :]


def _reworded(content: bytes, r: random.Random) -> bytes:
    """Replace a word or number of a text."""
    words = [m for m in _words(content) if m[1] > m[0]]
    if not words:
        return _flipped(content, r)
    a, b = r.choice(words)
    c, d = r.choice(words)
    return content[:a] + r.choice((*ODD, content[c:d])) + content[b:]


def _words(content: bytes) -> list[tuple[int, int]]:
    return [m.span() for m in re.finditer(rb"[\w.+-]+", content[:200_000])]


_DAMAGES: tuple[Damage, ...] = (_cut, _flipped, _swapped, _doubled, _lying, _reworded)
_OFTEN = (1, 4, 1, 1, 4, 5)


def changed(content: bytes, random_: random.Random) -> bytes:
    """Return a text with valid syntax and one to three changed values or lines."""
    for _ in range(random_.choice((1, 1, 2, 3))):
        content = random_.choices((_revalued, _relined), (4, 1))[0](content, random_)
    return content


_VALUE = re.compile(rb"(?<=\")[^\"\n]*(?=\")|(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")
_NUMBERS = (b"nan", b"inf", b"-1", b"0", b"1e308", b"1e-308", b"1e-9", b"1e12", b"3", b"999999999999999999999")


def _revalued(content: bytes, r: random.Random) -> bytes:
    """Replace a value, mostly by one of the same kind."""
    values = [m.span() for m in _VALUE.finditer(content)]
    if not values:
        return content
    a, b = r.choice(values)
    c, d = r.choice(values)
    numbers = content[a:b].split()
    if r.random() < 0.7 and all(_VALUE.fullmatch(n) for n in numbers) and numbers:
        numbers[r.randrange(len(numbers))] = r.choice(_NUMBERS)
        return content[:a] + b" ".join(numbers) + content[b:]
    return content[:a] + r.choice((*ODD[-3:-1], b"", content[c:d])) + content[b:]


def _relined(content: bytes, r: random.Random) -> bytes:
    """Remove, repeat or move a line."""
    lines = content.split(b"\n")
    line = lines.pop(r.randrange(len(lines)))
    for _ in range(r.randrange(3)):
        lines.insert(r.randrange(len(lines) + 1), line)
    return b"\n".join(lines)


# ---------------------------------------------------------------- trying


def attempt_file(number: int) -> str:
    """Damage a file and read it as wmspec would; return how far that came. Raises defects of wmspec.

    Its folder is nested, so that writes outside of it are detected.
    """
    return _attempt(KINDS[number % len(KINDS)], random.Random(f"file {number}"), damaged)  # noqa: S311


def attempt_changed(number: int) -> str:
    """Like `attempt_file`, for a readable file with changed values."""
    return _attempt(CHANGED[number % len(CHANGED)], random.Random(f"changed {number}"), changed)  # noqa: S311


def _attempt(kind: str, random_: random.Random, damage: Damage) -> str:
    with tempfile.TemporaryDirectory(prefix="fuzz") as root:
        home = Path(root) / "a" / "b" / "c"
        home.mkdir(parents=True)
        try:
            with warnings.catch_warnings(record=True, action="always", category=RuntimeWarning) as caught:
                _TRY[kind](home, random_, damage)
            came = "read"
        except WmsError as error:
            error.render()
            came = "refused"
        assert not caught, f"it warns: {caught[0].message} ({caught[0].filename}:{caught[0].lineno})"
        outside = [p for p in Path(root).rglob("*") if p.is_file() and not p.is_relative_to(home)]
        assert not outside, f"written outside: {outside}"
    return f"{kind} {came}"


def _manifest(home: Path, r: random.Random, damage: Damage) -> None:
    folder = _copied(home)
    path = folder / "manifest.json"
    path.write_bytes(damage(path.read_bytes(), r))
    gallery_folder(DatasetReader.open(folder), 2, home / "out")


def _copied(home: Path) -> Path:
    shutil.copytree(originals() / "dataset", home / "dataset")
    return home / "dataset"


def _chosen(folder: Path, r: random.Random) -> str:
    return str(r.choice(sorted(folder.glob("data/*/*.parquet"))).relative_to(folder))


def _shard(home: Path, r: random.Random, damage: Damage) -> None:
    folder = _copied(home)
    name = _chosen(folder, r)
    (folder / name).write_bytes(damage((folder / name).read_bytes(), r))
    signed(folder, name)
    gallery_folder(DatasetReader.open(folder), 2, home / "out")


def _rows(home: Path, r: random.Random, _: Damage) -> None:
    folder = _copied(home)
    rewritten(folder, _chosen(folder, r), lambda rows: _other(r.choice(rows), r))
    gallery_folder(DatasetReader.open(folder), 2, home / "out")


def _other(row: dict[str, Any], r: random.Random) -> None:
    """Replace a value of a row by another of the same type."""
    name = r.choice(sorted(row))
    row[name] = instead(row[name], r)


def instead(value: Any, r: random.Random) -> Any:
    """Return another value of the same type, or None."""
    match value:
        case bool():
            return r.choice((not value, None))
        case int():
            return r.choice((-1, 0, 99, 2**62, None))
        case float():
            return r.choice((math.nan, math.inf, -1.0, 1e308, None))
        case str():
            return r.choice(("", "../../x", "\x1b[2J<script>", "x" * 10_000, None))
        case bytes():
            return r.choice((b"", damaged(value, r)))
        case dict():
            name = r.choice(sorted(value))
            return {**value, name: instead(value[name], r)}
        case list() if value:
            at = r.randrange(len(value))
            return r.choice(([], value * 2, value[1:], [*value[:at], instead(value[at], r), *value[at + 1 :]]))
    return value


def _arrays(home: Path, r: random.Random, _: Damage) -> None:
    """Change numbers of an array of a trace."""
    path = home / "trace.npz"
    shutil.copy(originals() / "trace.npz", path)
    with np.load(path) as file:
        name = r.choice(sorted(file.files))
        array = file[name].copy()
    if array.dtype.kind == "f" and array.size and r.random() < 0.6:
        array.flat[r.randrange(array.size)] = r.choice((math.nan, math.inf, -1.0, 1e308, 1e-308, 0.0))
    else:
        array = r.choice((array[:0] if array.ndim else array, array.astype("U9"), array[..., None], np.array(7), None))
    resaved(path, **{name: array})
    load_episode(path)


def _results(home: Path, r: random.Random, _: Damage) -> None:
    rows, about = results.read(originals() / "results.parquet")
    for _time in range(r.choice((1, 2))):
        _other(r.choice(rows), r)
    results.write(home / "r.parquet", rows, about)
    replies.read([home / "r.parquet"], None)
    results.rescore(home / "r.parquet")


def _table(home: Path, r: random.Random, damage: Damage) -> None:
    shutil.copytree(originals() / "photos", home / "photos")
    (home / "t.csv").write_bytes(damage(TABLE, r))
    import_images(home / "t.csv", home / "photos", home / "out", 32)


def _of_trace(home: Path, r: random.Random, damage: Damage) -> None:
    path = home / "trace.npz"
    if r.random() < 0.4:
        path.write_bytes(damage((originals() / "trace.npz").read_bytes(), r))
    else:  # an archive that is whole, of arrays that are not
        with np.load(originals() / "trace.npz") as file:
            members = {name: _saved(file[name]) for name in file.files}
        name = r.choice(sorted(members))
        members[name] = damage(members[name], r)
        with zipfile.ZipFile(path, "w") as archived:
            for each, content in members.items():
                archived.writestr(f"{each}.npy", content)
    load_episode(path)


def _saved(array: np.ndarray) -> bytes:
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()


def _stage(home: Path, r: random.Random, damage: Damage) -> None:
    name = "executed.usda" if damage is changed else r.choice(("stage.usda", "crate.usdc"))
    (home / name).write_bytes(damage((originals() / name).read_bytes(), r))
    stage = open_stage(home / name)
    if read(stage) and damage is changed:
        run(stage, "mujoco", 0.02)


def _checked(home: Path, what: str) -> None:
    report = Report()
    program = load_source(Source(str(home / "t.wms"), SPEC.format(what=what)), home, report)
    for spec in check_program(program, report):
        dry_run(spec, report)
    report.stop_if_failed()


def _asset(name: str) -> Attempt:
    def attempt(home: Path, r: random.Random, damage: Damage) -> None:
        for beside in ("parts", "pictures"):
            shutil.copytree(originals() / beside, home / beside)
        (home / name).write_bytes(damage((originals() / name).read_bytes(), r))
        _checked(home, f'file: "{name}"')

    return attempt


def _mesh(home: Path, r: random.Random, damage: Damage) -> None:
    _asset(f"mesh.{r.choice(TEXTS if damage is changed else MESHES)}")(home, r, damage)


def _picture(home: Path, r: random.Random, damage: Damage) -> None:
    name = r.choice(("picture.png", "picture.jpg"))
    (home / name).write_bytes(damage((originals() / name).read_bytes(), r))
    _checked(home, f'shape: cube  size: 5 cm  image: "{name}"')


_TRY: dict[str, Attempt] = {
    "manifest": _manifest,
    "shard": _shard,
    "rows": _rows,
    "trace": _of_trace,
    "arrays": _arrays,
    "results": _results,
    "table": _table,
    "stage": _stage,
    "usd": _asset("usd.usda"),
    "urdf": _asset("urdf.urdf"),
    "mjcf": _asset("mjcf.xml"),
    "mesh": _mesh,
    "picture": _picture,
}
