"""Specs to test with: those that come with wmspec, and random ones."""

from functools import cache
from pathlib import Path

from hypothesis import strategies as st

from wmspec.check.ir import TaskSpec
from wmspec.check.task import check_program
from wmspec.parse.diagnostics import Report
from wmspec.parse.load import library_folder, load, load_source
from wmspec.parse.source import Source

ROOT = library_folder().parent
SPECS = [p for p in sorted(ROOT.rglob("*.wms")) if p.parent != library_folder()]


@cache
def task_of(path: Path) -> TaskSpec:
    """The only task of a spec that has no mistakes."""
    report = Report()
    (spec,) = check_program(load(path, report), report)
    report.stop_if_failed()
    return spec


def task_from(text: str) -> TaskSpec:
    """The only task in a text that has no mistakes."""
    report = Report()
    tasks = check_program(load_source(Source("test.wms", text), Path(), report), report)
    report.stop_if_failed()
    return tasks[0]


_COLORS = st.lists(st.sampled_from(["red", "green", "blue", "yellow"]), min_size=2, max_size=3, unique=True)
_SHAPES = st.lists(
    st.sampled_from(["sphere", "cube", "cylinder", "cone", "capsule"]), min_size=2, max_size=3, unique=True
)
_SIZES = st.lists(st.integers(4, 12), min_size=2, max_size=3, unique=True)


@st.composite
def random_text(draw: st.DrawFn) -> str:
    """A task of one to three objects whose properties depend on random factors, directly or through others."""
    names = ["a", "b", "c"][: draw(st.integers(1, 3))]
    domains = {
        "tone": f"[{', '.join(draw(_COLORS))}]",
        "form": f"[{', '.join(draw(_SHAPES))}]",
        "big": f"[{', '.join(map(str, draw(_SIZES)))}] cm",
        "pace": "[0.3, 0.6] m/s",
        "which": "[a, c]" if len(names) == 3 else "[a]",
    }
    lines = [f"  factor {name} in {domain}" for name, domain in domains.items()]
    lines += ["  nuisance turn in -20 deg .. 20 deg", "  let half = big / 2", "  let place = half + 20 cm"]
    for i, name in enumerate(names):
        shape = draw(st.sampled_from(["form", "sphere", "cube"]))
        color = draw(st.sampled_from(["tone", "purple", f"if which == {name} then red else tone"]))
        size = draw(st.sampled_from(["big", "6 cm", "half"]))
        x = draw(st.sampled_from(["place", "10 cm", "big * 2"]))
        yaw = draw(st.sampled_from(["turn", "0 deg"]))
        mass = draw(st.sampled_from(["100 g", f"{names[i - 1]}.mass * 2" if i else "50 g"]))
        lines.append(
            f"  object {name} {{ shape: {shape} color: {color} size: {size} mass: {mass} yaw: {yaw} "
            f"on: table at ({x} - {30 * i} cm, {20 * i} cm) }}"
        )
    other = names[-1]
    direction = draw(st.sampled_from(["turn", "30 deg", f"toward({other})" if other != "a" else "0 deg"]))
    lines.append(f"  action go = launch(a, direction: {direction}, speed: pace) at 0.1 s")
    lines.append("  observe front at 0 s .. 1 s in 3 frames")
    return "use tabletop\ntask random : custom {\n" + "\n".join(lines) + "\n}\n"


def random_spec() -> st.SearchStrategy[TaskSpec]:
    """The same, checked."""
    return random_text().map(task_from)
