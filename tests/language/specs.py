"""Specs to test with: those that come with wmspec, and random ones."""

from functools import cache
from pathlib import Path

import pytest
from hypothesis import strategies as st

from wmspec.api import load_all
from wmspec.core.diagnostics import Report
from wmspec.core.places import Source
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.parse.files import catalogue_folders
from wmspec.lang.parse.load import load_source

SPECS = sorted(path for folder in catalogue_folders() for path in folder.rglob("*.wms"))
#: For laws that take long and are the same of each: every fourth, and the others where slow tests run.
FEW = [path if i % 4 == 0 else pytest.param(path, marks=pytest.mark.slow) for i, path in enumerate(SPECS)]


@cache
def task_of(path: Path) -> TaskSpec:
    """The first task of a spec that has no mistakes; its variants, if it has any, differ in the setting.

    It comes from the cache that the processes of a session share: checking the catalogue takes a minute.
    """
    return load_all(path, tell=lambda _: None)[0].spec


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


SHELF = """template shelf(width: 30 cm, hollow: 12 cm) {
  color: oak
  part left   { shape: box  size: (2 cm, 8 cm, hollow)  at: (-width / 2, 0, hollow / 2) }
  part right  { shape: box  size: (2 cm, 8 cm, hollow)  at: (width / 2, 0, hollow / 2)  material: stuff }
}
"""
FACTORS = {"pace": '[0.3 m/s called "slow", 0.6 m/s called "fast"]',
            "stuff": "[plastic, wood, stone]", "lean": "[0, 12] deg", "n": "[1, 3]",
            "spot": "[(10 cm, -20 cm), (12 cm, -24 cm)]"}  # fmt: skip


@st.composite
def random_text(draw: st.DrawFn, grouped: bool = False) -> str:
    """A task of a few objects whose properties depend on random factors, directly or through others.

    If it is `grouped`, its design is in groups, the options are the siblings in the group, and answers may be balanced.
    """
    names = ["a", "b", "c"][: draw(st.integers(1, 3))]
    domains = {
        "tone": f"[{', '.join(draw(_COLORS))}]",
        "form": f"[{', '.join(draw(_SHAPES))}]",
        "big": f"[{', '.join(map(str, draw(_SIZES)))}] cm",
        "which": f"[{', '.join(names)}]",
        **FACTORS,
    }
    lines = [f"  factor {name} in {domain}" for name, domain in domains.items()]
    lines += ["  nuisance turn in -20 deg .. 20 deg", "  let half = big / 2", "  let place = half + reach"]
    lines += [draw(st.sampled_from(SETTINGS))]
    lines += [_object(draw, names, i) for i in range(len(names))]
    lines += ["  object spare { shape: cube  size: 3 cm  material: stuff  at: (0, 1 m, 1 m) }",
              "  action shove = impulse(spare, direction: left, impulse: 0.1 kg * pace) at 0.3 s"]  # fmt: skip
    lines += [line for line in OTHERS if draw(st.booleans())]
    deeds = draw(st.sampled_from(DEEDS))
    changes = [*_CHANGES, *["counterfactual swapped { order go, on }"] * ("action on" in deeds)]
    lines += [f"  {deeds}", "  observe front at 0 s .. 1 s in 3 frames"]
    if grouped:
        balance = draw(st.sampled_from(["", "balance: low"]))
        lines.append(f"  design groups of 7 {{ cross: [pace, stuff]  turn: [tone, big]  {balance} }}")
        changes = ["options orbit of pace, stuff  kinds { low: height(spare) < place  high: true }",
                   "distinct by half or 20 deg"]  # fmt: skip
    lines.append(f'  question "And then, {{pace}}?" {{ answer frame(front, end) {" ".join(changes)} }}')
    lines.append('  question low "Is it low?" { answer height(spare) < 5 cm }')
    lines += [f"  {line}" for line in MEASURED if draw(st.booleans())]
    lines += [OPENED] * any("joint rail" in line for line in lines)
    return SHELF + "task random : custom {\n" + "\n".join(lines) + "\n}\n"


def _object(draw: st.DrawFn, names: list[str], i: int) -> str:
    def one(*choices: str) -> str:
        return draw(st.sampled_from(choices))

    name, before = names[i], names[i - 1] if i else ""
    color = one("color: tone", "color: purple", f"color: if which == {name} then red else tone", "")
    size, x = one("big", "6 cm", "half"), one("place", "10 cm", "big * 2")
    mass = one("mass: 100 g", f"mass: {before}.mass * 2" if i else "mass: 50 g")
    at = f"table at ({x} - {30 * i} cm, {15 * i} cm)"
    beside = (
        f"{before} at (0, 0)",
        *(f"table at {f}" for f in (f"left_of({before}, place)", f"polar({before}, place / 2, turn)")),
    )
    on = one(at, *(beside if i else ()))
    return (
        f"  object {name} {{ shape: {one('form', 'sphere', 'cube')} {color} material: {one('stuff', 'rubber')} "
        f"size: {size} {mass} yaw: {one('turn', '0 deg')} pitch: {one('lean', '0 deg')} on: {on} }}"
    )


SETTINGS = (
    "  use tabletop  let reach = 20 cm",
    "  variant wide { use tabletop  let reach = 20 cm }\n  variant close { use tabletop_cool  let reach = 16 cm }",
    "  variant close { use tabletop_cool  let reach = 16 cm }\n  variant wide { use tabletop  let reach = 20 cm }",
)
"""Where it is: one place, or one of two variants, of which the first is taken."""

OTHERS = (
    """
  object rack : shelf { hollow: big  width: 3 * big  on: table at (0, 30 cm)  fixed: true }
  object pea  { shape: sphere  size: half  inside: rack at (0, 0) }""",
    """
  object ramp  { shape: wedge  size: (20 cm, 10 cm, big)  on: table at spot  fixed: true  yaw: lean }
  object rider { shape: cube  size: 3 cm  material: stuff  on: ramp at (-1 cm, 0) }""",
    """
  objects dots[n] { shape: cube  size: 2 cm + index * 1 mm  on: table at (0, -20 cm)  scatter: (40 cm, place) }""",
    """
  object frame { shape: box  size: (2 cm, 2 cm, big)  at: (-40 cm, 20 cm, half)  fixed: true }
  object door  { shape: box  size: (8 cm, 1 cm, big)  at: (-34 cm, 20 cm, half)  color: tone }
  joint swing : hinge { of: door  to: frame  at: (-39 cm, 20 cm, half)  high: lean + 60 deg }""",
    """
  object eyed { shape: sphere  size: half  on: table at left_of(a, 40 cm)  present: which == a }
  object next { shape: cube  size: 3 cm  on: table at polar(eyed, 10 cm, turn)  present: n > 1 }
  action roll = launch(next, direction: toward(eyed), speed: 0.1 m/s) at 0.7 s
  camera eye { ride: a  at: (0, 0, place)  look_at: (1 m, 0, big) }""",
    """
  objects beads[n] { shape: capsule  radius: 4 mm  height: half  at: (50 cm, -40 cm, 60 cm - index * half) }
  joint hung : ball { of: beads[0]  at: (50 cm, -40 cm, 60 cm + half / 2)  present: lean > 0 deg }
  joints knots[n - 1] : hinge { of: beads[index + 1]  to: beads[index]  at: (50 cm, -40 cm, 60 cm - half * index) }
  object pipe { shape: tube  radius: big  height: place  thickness: half / 4  on: table at (45 cm, 35 cm) }""",
    """
  object dolly { shape: sphere  size: 2 cm  solid: false  drawn: n > 1  at: (0, -60 cm, place) }
  camera riding { ride: dolly  at: (0, 0, 10 cm)  look_at: (0, 60 cm, 0) }
  action roam = follow(dolly, arc, direction: lean, length: place, width: half, facing: n > 1) for 0.4 s at 0.1 s""",
    """
  use rope(top: (-60 cm, 40 cm, 80 cm), length: place, lean: lean) as string""",
    """
  use household as home only [book]
  object novel : home.book { wide: big  on: table at (-45 cm, -30 cm)  called: "novel" }
  object vase  { shape: lathe  profile: [(0, 0), (half, 0), (2 cm, place / 2), (0, place / 2)]  on: table at spot }
  object step  { shape: extrude  outline: [(0, 0), (big, 0), (0, half)]  depth: place / 3  at: (80 cm, 0, big) }
  object wire  { shape: sweep  along: [(0, 0, 0), (big, 0, 0), (big, half, 0)]  thickness: 4 mm  at: (1 m, 0, big) }
  object ring  { shape: torus  size: big  thickness: half / 3  color: tone  at: (80 cm, -20 cm, place) }
  object soap  { shape: box  size: (big, 6 cm, 2 cm)  round: half / 8  at: (80 cm, 40 cm, big)  yaw: turn }""",
    """
  objects coins[n] { shape: cylinder  radius: 1 cm  height: half  at: (70 cm + 5 cm * index, hop[index], place) }
  nuisance hop[n] in -1 cm .. 1 cm
  actions toss[n] = launch(coins[index], direction: turn, speed: pace * (index + 1)) at 0.1 s * n when which == a
  action tint     = paint(spare, color: green) at 0.3 s when n > 1 and lean > 0 deg""",
    """
  object lid { shape: box  size: (big, 4 cm, 1 cm)  at: (-80 cm, 20 cm, place) }
  joint rail : slider { of: lid  at: (-80 cm, 20 cm, place)  axis: (1, 0, 0)  low: 0 cm  high: half }""",
)
"""More that a scene may have."""

MEASURED = (
    """question high "When is the {spare} highest?" { answer when_highest(spare, from: 0.1 s, to: 0.9 s)  within 50 ms }
  question far "How far" "is it then?" { answer position(spare, at: 0.2 s * n).x - place  within half }""",
    """question many "How many lie?" { options [0, 1, 2]  answer count(toppled([a, spare], at: 0.5 s)) }
  question some "Does one?" { answer any(contact([a, spare], table, from: 0.1 s)) and not all(at_rest([a, spare])) }""",
    """question gone "And without it?" { answer contact(a, table) without spare }
  question held "And if it were heavy?" { answer height(a) under state spare.mass: 2 kg  within half }
  question pink "Slowly?" { answer toppled(a) under pace: "slow" }""",
    """question left "And without the push?" { answer at_rest(spare) without go }
  question most "And the other?" { answer toppled(a) without (if n > 1 then spare else spare) }
  question blame "Whose fault?" { options [spare, table]  answer cause of toppled(a) among [spare, table] }""",
    """question seen "Where?" { options [left_of, behind]  answer relation(spare, a, at: 0.1 s * n, seen_from: side) }
  question met "Which first?" { options [a, table, neither]  answer touches_first(spare, [a, table], tie: 9 ms) }""",
)
"""What may be asked beside the pictures: at a time, of events, over several, from elsewhere."""

OPENED = """  question out "How far out is it?" { answer extension(rail, at: 0.1 s * n)  within half / 4 }"""
"""What may be asked of a joint."""

DEEDS = (
    "action go = launch(which, direction: turn, speed: pace, climb: lean) at 0.1 s",
    "action go = launch(a, direction: toward(which), speed: pace) at 0.1 s",
    """action go = launch(which, direction: turn, speed: pace) at 0.1 s
  action far = teleport(a, to: spot) at 0.5 s when n > 1""",
    """action go = glide(which, direction: lean, speed: pace) for 0.2 s
  action on  = follow(which, zigzag, direction: away, length: place) for 0.5 s after go
  action far = teleport(a, to: spot, yaw: turn) at 0.9 s""",
    "action go = drop(which, half) at 0.2 s",
    """object block { shape: cube  size: half  color: tone  on: table at (50 cm, 30 cm) }
  action go = slide(block, direction: left, distance: place) at 0.2 s""",
    """action go = impulse(a, direction: nearer, impulse: 0.1 kg * pace)
  action on = force(which, direction: turn, force: 0.2 N, climb: lean) for 0.2 s after go""",
)
"""What may happen."""

_CHANGES = (
    "counterfactual none    { without go }",
    "counterfactual later   { action go.start: go.start + 0.1 s }",
    "counterfactual larger  { state  a.size: a.size * 1.2 }",
    "counterfactual turned  { state  a.yaw: a.yaw + 10 deg }",
    "counterfactual painted { state  a.material: fabric }",
    "counterfactual each other pace",
    "counterfactual stopped { add stop(spare) at 0.6 s }",
    "counterfactual dyed    { add paint(spare, color: green) at 0.2 s * n }",
    "counterfactual gone    { add vanish(spare) at 0.9 s }",
    "counterfactual ghost   { add pass_through(spare, a) for 0.1 s * n at 0.5 s }",
    "counterfactual struck  { add impulse(spare, direction: turn, impulse: 0.1 kg * pace) at 0.5 s }",
)


def busy_text(deeds: str) -> str:
    """A task with everything that a scene of the random ones may have, in which this happens."""
    factors = {"tone": "[red, blue]", "form": "[sphere, cube]", "big": "[4, 8] cm", "which": "[a, b]", **FACTORS}
    lines = [f"  factor {name} in {domain}" for name, domain in factors.items()]
    lines += [
        "  nuisance turn in -20 deg .. 20 deg",
        "  let half = big / 2",
        "  let place = 24 cm",
        *OTHERS,
        f"  {deeds}",
    ]
    lines += ["  object a { shape: form  size: 6 cm  color: tone  material: stuff  on: table at spot  pitch: lean }",
              "  object b { shape: sphere  size: half  on: a at (0, 1 cm)  mass: n * 50 g }",
              "  object spare { shape: cube  size: 3 cm  material: stuff  at: (0, 1 m, 1 m) }",
              "  observe front at [0 s, 1 s]"]  # fmt: skip
    lines.append(f'  question "And then?" {{ answer frame(front, end) {" ".join(_CHANGES)} }}')
    lines += [*MEASURED, OPENED]
    return "use tabletop\n" + SHELF + "task busy : custom {\n" + "\n".join(lines) + "\n}\n"


def random_spec(grouped: bool = False) -> st.SearchStrategy[TaskSpec]:
    """The same, checked."""
    return random_text(grouped).map(task_from)
