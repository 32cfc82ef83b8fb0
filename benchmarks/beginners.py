"""Quality of diagnostics: mistakes that beginners make, and the messages of `wmspec check`.

    python -m benchmarks.beginners          scores
    python -m benchmarks.beginners --all    every message

A mistake scores a point each for exactly one diagnostic, on the line of the mistake, whose message or remedy has the
expected words.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

from wmspec.api.loading import diagnose
from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import Location, Span

#: A spec without mistakes; each mistake replaces one piece of it.
SPEC = """use room

task first : custom {
  factor tone in [red, blue]
  factor pace in [0.6, 0.9] m/s
  factor n in [2, 3]
  nuisance turn in -20 deg .. 20 deg
  let start = -44 cm
  object ball { shape: sphere  size: 14 cm  color: tone  on: floor at (start, 0) }
  object crate { shape: cube  size: 14 cm  color: green  on: floor at (10 cm, 0)  yaw: turn }
  objects dots[n] { shape: sphere  size: 4 cm  color: yellow  on: floor at (20 cm * index, 40 cm) }
  action push = launch(ball, direction: toward(crate), speed: pace) at 0.2 s
  horizon 1.2 s
  observe front at [0 s, 0.3 s]
  question hit "The {tone} ball goes towards the box. Does it touch the box?" {
    answer contact(ball, crate)
    ensure n < 4
  }
  question next "The {tone} ball goes towards the box. What comes next?" {
    answer frame(front, end)
    counterfactual slower { action push.speed: push.speed * 0.3 }
    counterfactual none { without push }
    ensure contact(ball, crate)
  }
}
"""


@dataclass(frozen=True)
class Mistake:
    """What is written, what instead, the line of the mistake, and what its message or remedy says."""

    name: str
    written: str
    instead: str
    line: int
    remedy: str


@dataclass(frozen=True)
class Score:
    """The points of a mistake and its diagnostics."""

    mistake: Mistake
    diagnostics: tuple[Diagnostic, ...]
    once: bool
    located: bool
    remedied: bool

    @property
    def points(self) -> int:
        """The points, 0 to 3."""
        return self.once + self.located + self.remedied


_BALL, _CRATE, _PUSH = "on: floor at (start, 0) }", "color: green", "speed: pace) at 0.2 s"
_ANSWER, _HIT = "answer contact(ball, crate)", 'question hit "The {tone} ball'
_NEXT = 'next "The {tone} ball goes towards the box. What comes next?"'
_END = "\n  }\n  horizon 1.2 s"
_OBJECT = "object o { size: 4 cm  on: floor at (1 m, 0) }"

MISTAKES = tuple(
    Mistake(*row)
    for row in (
        # colours
        ("a hexadecimal colour", _CRATE, "color: #ffcc00", 10, "rgb(100 %, 80 %, 0 %)"),
        ("a hexadecimal colour in quotes", _CRATE, 'color: "#ffcc00"', 10, "rgb(100 %, 80 %, 0 %)"),
        ("a colour in quotes", _CRATE, 'color: "green"', 10, "without quotes"),
        ("a colour of 255 parts", _CRATE, "color: rgb(255, 204, 0)", 10, "/ 255"),
        ("a colour as a tuple", _CRATE, "color: (1, 0.8, 0)", 10, "rgb("),
        ("a colour of another language", _CRATE, "color: vert", 10, "green"),
        # operators
        ("a chain of comparisons", "ensure n < 4", "ensure 1 < n < 4", 17, "1 < n and n < 4"),
        ("a chain of three", "ensure n < 4", "ensure 0 <= n - 1 <= 3", 17, "0 <= n - 1 and n - 1 <= 3"),
        ("a power", "ensure n < 4", "ensure n ** 2 < 16", 17, "n * n"),
        ("a power with a caret", "ensure n < 4", "ensure n ^ 2 < 16", 17, "n * n"),
        ("a remainder", "ensure n < 4", "ensure n % 2 == 0", 17, "mod("),
        ("a whole division", "ensure n < 4", "ensure n // 2 < 3", 17, "`#`"),
        ("not equal", "ensure n < 4", "ensure n <> 4", 17, "`!=`"),
        ("an exclamation mark", "ensure n < 4", "ensure !(n == 4)", 17, "`not`"),
        ("three equal signs", "ensure n < 4", "ensure n === 2", 17, "`==`"),
        ("or by bars", "ensure n < 4", "ensure n < 4 || n > 5", 17, "`or`"),
        ("membership", "ensure n < 4", "ensure n in [2, 3]", 17, "n == 2 or n == 3"),
        ("increment", "let start = -44 cm", "let start += 2 cm", 8, "="),
        ("is", "ensure n < 4", "ensure tone is red", 17, "`==`"),
        # lists and indices
        ("an index of a list", _CRATE, "color: [red, green][0]", 10, "pick("),
        ("an index of a named list", "-44 cm", "-44 cm\n  let ways = [1 m, 2 m]\n  let way = ways[0]", 10, "pick("),
        ("a member beyond the set", _ANSWER, "answer contact(ball, dots[7])", 16, "0 to 2"),
        ("an index by another name", "20 cm * index", "20 cm * idx", 11, "`index`"),
        ("a length by len", "ensure n < 4", "ensure len(dots) < 4", 17, "count"),
        ("a list in braces", "[red, blue]", "{red, blue}", 4, "[red, blue]"),
        ("a range of Python", "factor n in [2, 3]", "factor n in range(2, 3)", 6, ".."),
        ("a range with a hyphen", "[0.6, 0.9] m/s", "0.6 - 0.9 m/s", 5, ".."),
        ("a unit for each item and none for the first", "[0.6, 0.9] m/s", "[0.6, 0.9 m/s]", 5, "m/s"),
        # actions and blocks
        ("a singular set of actions", "action push =", "action push[n] =", 12, "actions push[n]"),
        ("a plural action", "action push =", "actions push =", 12, "actions push[NUMBER]"),
        ("a set with a singular keyword", "objects dots[n]", "object dots[n]", 11, "`objects"),
        ("a set without a number", "objects dots[n]", "objects dots", 11, "`objects dots[NUMBER]"),
        ("a condition before the verb", "push = launch(ball", "push = if n == 2 then launch(ball", 12, "when"),
        ("a block for", "horizon 1.2 s", "for i in range(3) {\n    " + _OBJECT + _END, 13, "objects"),
        ("a block if", "horizon 1.2 s", "if n == 2 {\n    " + _OBJECT + _END, 13, "present:"),
        ("a block while", "horizon 1.2 s", "while n < 2 {\n    horizon 1 s\n  }\n  horizon 1.2 s", 13, "objects"),
        ("a function", "horizon 1.2 s", "def half(x) = x / 2\n  horizon 1.2 s", 13, "let"),
        ("a statement print", "horizon 1.2 s", "print(n)\n  horizon 1.2 s", 13, "wmspec list"),
        ("no verb", "launch(ball, direction: toward(crate), speed: pace)", "ball", 12, "launch(ball"),
        ("a method", "launch(ball, direction", "ball.launch(direction", 12, "launch(ball"),
        ("an action after an object", _PUSH, "speed: pace) after crate", 12, "an action"),
        ("when as if", _PUSH, "speed: pace) at 0.2 s if n == 2", 12, "`when`"),
        ("a set of factors", "factor n in [2, 3]", "factor n[2] in [2, 3]", 6, "nuisance n[2]"),
        ("a cause without candidates", _ANSWER, "answer cause of contact(ball, crate)", 16, "among [a, b]"),
        ("a change of no kind", _ANSWER, _ANSWER + " under push.speed: 1 m/s", 16, "action push.speed"),
        # texts
        ("a sweep of a factor in a text", _HIT, 'question hit "At {pcae} the ball', 15, "`pace`"),
        ("a format in a text", _HIT, 'question hit "At {pace:.2f} the ball', 15, "{pace}"),
        ("a format of a percentage", _HIT, 'question hit "At {pace:5.1%} the ball', 15, "{pace}"),
        ("a dollar sign", _HIT, 'question hit "The ${tone} ball', 15, "{tone}"),
        ("a percent sign", _HIT, 'question hit "The %(tone)s ball', 15, "{tone}"),
        ("double braces", _HIT, 'question hit "The {{tone}} ball', 15, "{tone}"),
        ("a text in single quotes", _NEXT, "next 'What?'", 19, '"What?"'),
        ("a speed by a near name", _HIT, 'question hit "At {speed} the ball', 15, "push.speed"),
        # what is there and what is not
        ("cloth", "shape: cube", "shape: cloth", 10, "rigid"),
        ("liquid", "shape: cube", "shape: water", 10, "rigid"),
        ("a soft body", "shape: cube  size", "soft: true  shape: cube  size", 10, "rigid"),
        ("a liquid material", _CRATE, "material: liquid", 10, "rigid"),
        ("a rope as a shape", "shape: cube", "shape: rope", 10, "use rope"),
        ("a position", "on: floor at (10 cm, 0)", "position: (10 cm, 0, 7 cm)", 10, "`at`"),
        ("a rotation", "yaw: turn", "rotation: turn", 10, "`yaw`"),
        ("a radius of a cube", "shape: cube  size: 14 cm", "shape: cube  radius: 7 cm", 10, "size:"),
        ("a mass without unit", _CRATE, "color: green  mass: 2", 10, "2 g"),
        ("a length without unit", "size: 14 cm  color: green", "size: 14  color: green", 10, "14 cm"),
        ("a velocity in km/h", "[0.6, 0.9] m/s", "[2, 3] kmh", 5, "km/h"),
        ("degrees by their sign", "-20 deg .. 20 deg", "-20° .. 20°", 7, "deg"),
        ("a time without unit", "horizon 1.2 s", "horizon 1.2", 13, "1.2 s"),
        ("a what-if with if", _ANSWER, "answer contact(ball, crate) if not dots[0]", 16, "else"),
        ("a what-if of the removed", _ANSWER, "answer contact(ball, crate) without ball", 16, "nothing to measure"),
        ("an answer in quotes", _ANSWER, 'answer "yes"', 16, ""),
        ("options without an answer", _ANSWER, "options [ball, crate]", 15, "answer"),
    )
)  # fmt: skip


def diagnostics(text: str) -> tuple[Diagnostic, ...]:
    """Return all diagnostics of a text."""
    return diagnose(text=text).diagnostics


def score(mistake: Mistake) -> Score:
    """Return the score of a mistake."""
    assert SPEC.count(mistake.written) == 1, mistake.name
    found = diagnostics(SPEC.replace(mistake.written, mistake.instead))
    lines = {d.place.line for d in found if isinstance(d.place, Span | Location)}
    remedied = any(mistake.remedy in f"{d.message} | {d.help}" for d in found)
    return Score(mistake, found, len(found) == 1, mistake.line in lines, remedied)


def main() -> None:
    """Print the scores."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", action="store_true", help="print every message")
    every = parser.parse_args().all
    scores = [score(mistake) for mistake in MISTAKES]
    for each in scores:
        if every or each.points < 3:
            print(f"{each.points} {each.mistake.name}: {each.mistake.instead.splitlines()[0]}")
            for d in each.diagnostics:
                line = d.place.line if isinstance(d.place, Span | Location) else 0
                print(f"    {d.code} line {line} (of {each.mistake.line}): {d.message} | {d.help}")
    print(f"{len(scores)} mistakes, mean {sum(each.points for each in scores) / len(scores):.2f} of 3")


if __name__ == "__main__":
    main()
