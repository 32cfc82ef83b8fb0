"""Fetch public stages of other projects, run them in every engine and write docs/benchmarks/public_stages.md.

python -m tools.stages fetch FOLDER [--mirror M]   M/OWNER/NAME: local repositories instead of the network
python -m tools.stages robots FOLDER [--bin BIN]   with the converters in BIN, a separate environment
python -m tools.stages run FOLDER                  a second in each engine; finished stages are skipped
python -m tools.stages table FOLDER                rewrites the page from the results
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from itertools import combinations
from pathlib import Path
from typing import Any

import wmspec
from tests.engines import ENGINES
from tools.reference import table
from wmspec.core.diagnostics import WmsError

ROOT = Path(__file__).parent.parent
LIST, PAGE = ROOT / "tools/stages.toml", ROOT / "docs/benchmarks/public_stages.md"
START, STOP = "<!-- stages -->\n", "<!-- /stages -->\n"
SECONDS, PATIENCE = 1.0, 90  # how long each stage lasts, and how much of the processor (s) an engine may take for it
AGREE = 0.005  # m: what is nearer than this after that second counts as the same
SOFT = ("Deformable", "Particle", "Tendon", "Gear", "Vehicle")


def fetch(folder: Path, mirror: Path | None) -> None:
    """Extract the listed paths of each repository, at its commit, into a folder of its name."""
    for entry in tomllib.loads(LIST.read_text())["repository"]:
        target = folder / entry["name"].replace("/", "+")
        target.mkdir(parents=True, exist_ok=True)
        source = folder / f".{target.name}.git"
        if mirror is not None:
            source = mirror / entry["name"]
        elif not source.exists():
            url = f"https://github.com/{entry['name']}"
            git("clone", "--quiet", "--bare", "--filter=blob:none", url, str(source))
        archive = subprocess.run(
            ["git", "-C", str(source), "archive", entry["commit"], *entry["paths"]], check=True, capture_output=True
        )
        subprocess.run(["tar", "-x", "-C", str(target)], input=archive.stdout, check=True)


def git(*arguments: str) -> None:
    """Run git."""
    subprocess.run(["git", *arguments], check=True)


def robots(folder: Path, bin_: Path) -> None:
    """Convert the robots of PyBullet's wheel; failures of a converter are printed."""
    listed = tomllib.loads(LIST.read_text())["robots"]
    spec = find_spec("pybullet_data")
    assert spec is not None
    assert spec.submodule_search_locations
    data = Path(spec.submodule_search_locations[0])
    for kind, ending, program in (("urdf", "urdf", "urdf_usd_converter"), ("mjcf", "xml", "mujoco_usd_converter")):
        for name in listed[kind]:
            target = folder / "robots" / f"{kind}_{name.replace('/', '_')}"
            if not target.exists():
                subprocess.run([str(bin_ / program), str(data / f"{name}.{ending}"), str(target)], check=False)


def stages(folder: Path) -> list[Path]:
    """Return the stages that are not only parts of others."""
    entries = tomllib.loads(LIST.read_text())["repository"]
    chosen = []
    for entry in entries:
        below = sorted((folder / entry["name"].replace("/", "+")).rglob("*.usd*"))
        chosen += [path for path in below if path.name not in entry.get("parts", ()) and "_gpu" not in path.stem]
    return chosen + sorted((folder / "robots").glob("*/*.usda"))


def outcomes(path: Path) -> dict[str, Any]:
    """Return the result of a stage in every engine, each in its own process, which may crash."""
    results: dict[str, Any] = {}
    while waiting := [engine for engine in ENGINES if engine not in results]:
        command = [sys.executable, "-m", "tools.stages", "try", str(path), *waiting]
        printed = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False).stdout
        lines = [line for line in printed.splitlines() if line.startswith('{"')]  # engines may print, too
        results |= dict(zip(waiting, map(json.loads, lines), strict=False))
        if len(lines) < len(waiting):
            results[waiting[len(lines)]] = {"refused": f"it takes more than {PATIENCE} s, or the engine died of it"}
    return results


def attempt(path: Path, engine: str) -> dict[str, Any]:
    """Return the result of a stage in an engine, within `PATIENCE` seconds of processor time."""
    spent = resource.getrusage(resource.RUSAGE_SELF)
    most = int(spent.ru_utime + spent.ru_stime) + PATIENCE
    resource.setrlimit(resource.RLIMIT_CPU, (most, resource.RLIM_INFINITY))
    try:
        episode = wmspec.run(path, engine, SECONDS)
    except WmsError as error:
        return {"refused": str(error)}
    ends = {name: episode[name].center[-1].tolist() for name in episode.movable}
    return {"bodies": ends, "notes": [str(note) for note in episode.notes]}


def run(folder: Path) -> None:
    """Run every stage in every engine, small ones first; one result file per stage."""
    for path in sorted(stages(folder), key=lambda path: path.stat().st_size):
        kept = folder / "results" / f"{'+'.join(path.relative_to(folder).with_suffix('').parts)}.json"
        if kept.exists():
            continue
        kept.parent.mkdir(exist_ok=True)
        results = outcomes(path)
        kept.write_text(json.dumps(results))
        print(path.name, *("refused" if "refused" in one else "ran" for one in results.values()), flush=True)


def spread(results: dict[str, Any]) -> float | None:
    """Return the largest distance (m) between final positions in two engines; None for fewer than two engines."""
    ran = [one["bodies"] for one in results.values() if "bodies" in one]
    pairs = [(a[name], b[name]) for a, b in combinations(ran, 2) for name in a]
    if len(ran) < 2:
        return None
    return max((sum((x - y) ** 2 for x, y in zip(p, q, strict=True)) ** 0.5 for p, q in pairs), default=0.0)


def rigid(path: Path) -> bool:
    """Whether a stage contains only rigid bodies, no deformables, tendons, gears or vehicles."""
    from pxr import Usd

    stage = Usd.Stage.Open(str(path))
    apis = [api for prim in stage.Traverse() for api in prim.GetPrimTypeInfo().GetAppliedAPISchemas()]
    types = {str(prim.GetTypeName()) for prim in stage.Traverse()}
    soft = any(word in name for word in SOFT for name in (*apis, *types)) or {"Points", "TetMesh"} & types
    return "PhysicsRigidBodyAPI" in apis and not soft


def rows(folder: Path) -> tuple[list[tuple[str, ...]], dict[str, int]]:
    """Return the rows of the table, and the counts of stages."""
    made, counts = [], dict.fromkeys(("listed", "all", "rigid", "two", "three", "agree"), 0)
    for path in stages(folder):
        kept = folder / "results" / f"{'+'.join(path.relative_to(folder).with_suffix('').parts)}.json"
        counts["listed"] += 1
        if not kept.exists():
            continue
        results = json.loads(kept.read_text())
        ran = [engine for engine in ENGINES if "bodies" in results[engine]]
        apart, solid = spread(results), rigid(path)
        counts["all"] += 1
        counts["rigid"] += solid
        counts["two"] += solid and len(ran) >= 2
        counts["three"] += solid and len(ran) == len(ENGINES)
        counts["agree"] += solid and apart is not None and apart < AGREE
        notes = sum(len(results[engine].get("notes", ())) for engine in ran[:1])
        why = dict.fromkeys(results[e]["refused"].splitlines()[0][:150] for e in ENGINES if e not in ran)
        marks = ["✓" if engine in ran else "—" for engine in ENGINES]
        shown = "" if apart is None else f"{1e3 * apart:.1f}"
        name = f"`{path.parent.name}/{path.stem}`" if path.parent.parent.name == "robots" else f"`{path.stem}`"
        made.append((name, "" if solid else "no", *marks, str(notes or ""), shown, "; ".join(why).replace("|", "\\|")))
    return made, counts


def page(folder: Path) -> str:
    """Return the page with a current table."""
    made, n = rows(folder)
    head = ("stage", "rigid only", *ENGINES, "warnings", "apart, mm", "refused because")
    share = 100 * n["two"] / n["rigid"]
    summary = (
        f"Of the {n['listed']} listed stages, {n['all']} were run; {n['rigid']} of those have only rigid bodies. "
        f"Of these {n['rigid']}, {n['two']} run in at least two engines ({share:.0f} %) and {n['three']} in all three. "
        f"In {n['agree']} of them, the final positions of every body in these engines are less than {1e3 * AGREE:g} mm "
        "apart."
    )
    before, start, rest = PAGE.read_text().partition(START)
    return (
        before + start + "\n".join(["", summary, "", *table(head, iter(made)), "", ""]) + STOP + rest.partition(STOP)[2]
    )


def main() -> None:
    """Run the selected step."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("fetch", "robots", "run", "table", "try"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("engines", nargs="*", help=argparse.SUPPRESS)
    parser.add_argument("--mirror", type=Path)
    parser.add_argument("--bin", type=Path, default=Path(sys.executable).parent)
    options = parser.parse_args()
    match options.what:
        case "fetch":
            fetch(options.folder, options.mirror)
        case "robots":
            robots(options.folder, options.bin)
        case "run":
            run(options.folder)
        case "try":
            for engine in options.engines:
                print(json.dumps(attempt(options.folder, engine)), flush=True)
        case _:
            PAGE.write_text(page(options.folder))


if __name__ == "__main__":
    main()
