"""Hostile USD stages by a generator that composes: no stage may hang, fill the memory, crash, or show a traceback.

    python -m benchmarks.hostile_stages --count 1000

Each stage has up to nine layers that refer to one another by every kind of arc, in circles, through variables, into
packages, to pipes and devices, and deeply nested. A stage is read or refused in a process of its own.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import shutil
import struct
import tempfile
import zipfile
from collections import Counter
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from wmspec.api.episode import open_stage
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.workers.pool import HelperProcess, JobFailure
from wmspec.sim.usd import read

#: Limits of a stage: seconds, and bytes of resident memory.
SECONDS, BYTES = 120.0, 2**31
#: Layers, and what is no layer or no file.
LAYERS = ("a.usda", "b.usda", "c.usda", "d.usda")
OUTSIDE = (
    "./pipe.usda", "./absent.usda", "./folder.usda", "./e.usdc", "./f.usdz", "/dev/zero", "/dev/tty", "/etc/passwd",
    "../../../../etc/passwd", "file:///etc/passwd", "http://localhost:1/x",
)  # fmt: skip
PATHS = ("", "/P0", "/P1", "/P0/x", "/P1/x/y", "/C", "/Absent")


class Outcome(NamedTuple):
    """What happened to a stage: read, refused, or the failure."""

    number: int
    kind: str
    words: str
    seconds: float
    memory: int


class _Chance(random.Random):
    """Draws of a stage; `odd` is true with the stage's own share of what makes it hostile."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.share = self.choice((0.0, 0.01, 0.05, 0.3))
        self.later: tuple[str, ...] = LAYERS  # the layers after the one that is written

    def odd(self) -> bool:
        """Whether to write something that no honest stage has."""
        return self.random() < self.share


def stage(number: int, folder: Path) -> Path:
    """Write a hostile stage, a pure function of its number; return the path of its root layer."""
    chance = _Chance(number)
    os.mkfifo(folder / "pipe.usda")
    (folder / "folder.usda").mkdir()
    for place, name in enumerate(LAYERS, 1):
        chance.later = LAYERS[place:] or ("absent.usda",)
        (folder / name).write_text(_layer(chance))
    (folder / "e.usdc").write_bytes(_crate(chance, folder))
    _package(chance, folder)
    return folder / (chance.choice(("e.usdc", "f.usdz")) if chance.odd() else "a.usda")


def _layer(chance: _Chance) -> str:
    head = [f"subLayers = [{', '.join(_asset(chance) for _ in range(chance.randrange(3)))}]"]
    if chance.random() < 0.5:
        head.append('defaultPrim = "P0"')
    if chance.random() < 0.5:
        head.append(_variables(chance))
    if chance.odd():
        head.append(f"upAxis = {chance.choice(('3', '[]'))}")
    prims = "\n".join(_prim(chance, f"P{number}", chance.randrange(1, 5)) for number in range(chance.randrange(1, 4)))
    text = f'#usda 1.0\n(\n{chr(10).join(head)}\n)\n{prims}\nclass "C" {{\n{_prim(chance, "x", 2)}\n}}\n'
    return _damaged(chance, text) if chance.odd() else text


def _variables(chance: _Chance) -> str:
    first = chance.choice(("pipe", "/dev/zero", "x" * 400) if chance.odd() else ("a", "b"))
    values = [f'string V0 = "{first}"']
    values += [
        f"string V{number} = \"`'${{V{number - 1}}}${{V{max(0, number - 2)}}}'`\""
        for number in range(1, 40 if chance.odd() else 5)
    ]
    return "expressionVariables = {\n" + "\n".join(values) + "\n}"


def _asset(chance: _Chance) -> str:
    if chance.share and chance.random() < 0.1:
        return f'@`"./${{V{chance.randrange(6)}}}.usda"`@'
    if chance.odd():
        return f"@{chance.choice(OUTSIDE)}@"
    if chance.odd():
        return f"@./f.usdz[{chance.choice(('g.usda', '../a.usda', '/etc/passwd', 'f.usdz[g.usda]'))}]@"
    return f"@./{chance.choice(LAYERS if chance.odd() else chance.later)}@"


def _arc(chance: _Chance) -> str:
    target = chance.choice(PATHS)
    named = f"{_asset(chance)}{f'<{target}>' if target else ''}"
    inner = f"<{target or '/P0'}>"
    kind = chance.choice(("references", "payload", "inherits", "specializes", "prepend references"))
    return f"{kind} = {inner if kind in ('inherits', 'specializes') or chance.random() < 0.3 else named}"


def _prim(chance: _Chance, name: str, depth: int) -> str:
    metadata = [_arc(chance) for _ in range(chance.randrange(2))]
    if chance.odd():
        metadata.append(_clips(chance))
    body = [_attribute(chance) for _ in range(chance.randrange(3))]
    if depth and chance.random() < 0.9:
        many = chance.choice((1, 2, 10)) if depth < 4 else 1
        body += [_prim(chance, f"{'xyz'[k % 3]}{k // 3 or ''}", depth - 1) for k in range(many)]
    if chance.random() < 0.15:
        metadata.append('variantSets = "v"\nvariants = {\nstring v = "one"\n}')
        body.append(f'variantSet "v" = {{\n"one" (\n{_arc(chance)}\n) {{\n{_attribute(chance)}\n}}\n"two" {{\n}}\n}}')
    if chance.odd() and chance.odd():
        deep = chance.choice((50, 2_000, 40_000))
        body.append('def "n" {\n' * deep + "}\n" * deep)
    kind = chance.choice(
        ("def Xform", "def Sphere", "def Mesh", "over", "def", "def PhysicsScene", "def PointInstancer")
    )
    return f'{kind} "{name}" (\n{chr(10).join(metadata)}\n)\n{{\n{chr(10).join(body)}\n}}\n'


def _clips(chance: _Chance) -> str:
    return f"""clips = {{
dictionary default = {{
asset[] assetPaths = [{_asset(chance)}]
asset manifestAssetPath = {_asset(chance)}
string primPath = "/P0"
string templateAssetPath = "./pipe.###.usda"
double templateStartTime = 0
double templateEndTime = {chance.choice((3, 1e12))}
double templateStride = {chance.choice((1, 1e-9))}
}}
}}"""


def _attribute(chance: _Chance) -> str:
    if not chance.odd():
        return chance.choice(("double radius = 1", "custom double x.timeSamples = {\n0: 1,\n1: 2\n}"))
    return chance.choice((
        "double radius = -1",
        "double radius = 1e308",
        "point3f[] points = [(nan, inf, 0)]",
        "int[] faceVertexCounts = [3, -1, 2000000000]",
        "int[] faceVertexIndices = [0, 99999999]",
        f"asset inputs:file = {_asset(chance)}",
        f"rel material:binding = <{'/x' * chance.choice((1, 300))}>",
        'double3 xformOp:translate = (1e300, 0, 0)\nuniform token[] xformOpOrder = ["xformOp:translate"]',
        'uniform token[] apiSchemas = ["PhysicsRigidBodyAPI"]',
    ))  # fmt: skip


def _damaged(chance: _Chance, text: str) -> str:
    at = chance.randrange(len(text))
    return text[:at] + chance.choice(("", "{" * 500, "(" * 500, "@", '"', "\0", "<" + "/a" * 2000)) + text[at + 1 :]


def _crate(chance: _Chance, folder: Path) -> bytes:
    """A binary layer with damaged bytes."""
    from pxr import Sdf

    layer = Sdf.Layer.CreateNew(str(folder / "made.usdc"))
    layer.ImportFromString('#usda 1.0\ndef Sphere "P0" (\nreferences = @./a.usda@\n)\n{\n}\n')
    layer.Save()
    content = bytearray((folder / "made.usdc").read_bytes())
    for _ in range(chance.choice((0, 1, 4, 30))):
        at = chance.randrange(8, len(content) - 8)
        content[at : at + 8] = struct.pack("<Q", chance.choice((0, 2**62, 2**31, chance.getrandbits(60))))
    return bytes(content)


def _package(chance: _Chance, folder: Path) -> None:
    """A package whose names lead out of it."""
    with zipfile.ZipFile(folder / "f.usdz", "w", zipfile.ZIP_STORED) as package:
        for name in ("g.usda", chance.choice(("../a.usda", "/tmp/x.usda", "g/../../b.usda", "c.usda"))):  # noqa: S108
            package.writestr(name, _layer(chance))


def attempt(number: int, folder: str) -> Outcome:
    """Read a stage; return whether it is read or refused. Other exceptions are failures."""
    begin = perf_counter()
    path = stage(number, Path(folder))
    try:
        read(open_stage(path))
        kind, words = "read", ""
    except WmsError as error:
        kind, words = "refused", str(error).splitlines()[0][:200]
    except Exception as error:  # noqa: BLE001  that is what is looked for
        kind, words = "failed", f"{type(error).__name__}: {error}"[:300]
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return Outcome(number, kind, words, perf_counter() - begin, memory)


def run(numbers: range, max_time: float) -> list[Outcome]:
    """Try stages one by one for at most `max_time` seconds; a process that hangs or crashes is replaced."""
    from benchmarks.hostile_stages import attempt as work  # by its name, so that the process finds it

    helper, outcomes = HelperProcess(SECONDS), list[Outcome]()
    end = perf_counter() + max_time
    try:
        for number in numbers:
            if perf_counter() > end:
                break
            folder = tempfile.mkdtemp()
            begin = perf_counter()
            made = helper.do(work, number, folder)
            shutil.rmtree(folder)
            if isinstance(made, JobFailure):
                made = Outcome(number, "failed", f"{made.kind}: {made.reason}", perf_counter() - begin, 0)
            elif made.memory > BYTES:
                made = made._replace(kind="failed", words=f"{made.memory >> 20} MB")
            outcomes.append(made)
    finally:
        helper.close()
    return outcomes


def main() -> None:
    """Try stages, print the figures, and the failures with their numbers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--max-time", type=float, default=36_000.0, help="seconds after which no stage is begun")
    options = parser.parse_args()
    outcomes = run(range(options.first, options.first + options.count), options.max_time)
    counts = Counter(outcome.kind for outcome in outcomes)
    slowest = max(outcome.seconds for outcome in outcomes)
    print("| stages | read | refused | failed | slowest | most memory |\n|---|---|---|---|---|---|")
    memory = max(outcome.memory for outcome in outcomes) >> 20
    cells = (len(outcomes), *(counts[kind] for kind in ("read", "refused", "failed")))
    print(f"| {' | '.join(f'{cell:,}' for cell in cells)} | {slowest:.2f} s | {memory} MB |")
    for outcome in outcomes:
        if outcome.kind == "failed":
            print(f"{outcome.number}: {outcome.words}")


if __name__ == "__main__":
    main()
