"""Inputs for the fuzzer: random words, sentences of the grammar, damaged specs, and crossed specs.

Sources are the specs and libraries, the corpus, and every example of the documentation.
"""

from __future__ import annotations

import random
import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any

from lark.grammar import NonTerminal, Rule, Symbol

from wmspec.core.diagnostics import Report
from wmspec.core.places import Source, Span
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.codes import CODES
from wmspec.lang.parse.files import library_folder
from wmspec.lang.parse.pages import page
from wmspec.lang.parse.parser import parse, tokens_and_comments
from wmspec.lang.parse.tables import grammar, lark_parser

ROOT = Path(__file__).parent.parent
ODD: list[str] = [*'{}()[]":,-*#é\U0001f600\x00\r\t', '"""', "..", "at", "if", "then", "else", "with", "after"]
ODD += ["0", "1e9", "1e999", "1e-999", "m^99", "0 .. 1e9 by 1e-9", "9" * 400, "(" * 300, "-" * 300, "not " * 99, '"{"']
NUMBERS = ["0", "1", "2", "3.5", "12", "500", "501", "1e6", "1e15", "1e200", "1e308", "0.001", "1e-12", "1e-300"]
MESHES = """use tabletop
task meshes : custom {
  factor file  in ["cup.obj", "wedge.stl"]
  factor touch in [hull, pieces, bounds]
  object cup  { file: file  scale: 0.01  collision: touch  on: table at (0, 0)  yaw: 20 deg }
  object hat  { shape: cylinder  size: 3 cm  image: "label.png"  on: cup at (0, 0) }
  action push = launch(cup, direction: left, speed: 20 cm/s) at 0.2 s
  observe front at 0 s .. 1 s in 3 frames
  question "How far does it go?" { answer displacement(cup)  within 1 cm }
}
"""


def text_of(number: int) -> str:
    """Return input `number`, a pure function of it."""
    rng = random.Random(number)  # noqa: S311
    make = rng.choices((_words, _grown, _damaged, _crossed), (1, 2, 3, 10))[0]
    text: str = make(rng)
    return text


@cache
def texts() -> tuple[str, ...]:
    """Return the source texts."""
    folders = (library_folder().parent, ROOT / "tests")
    found = [path.read_text(encoding="utf-8") for folder in folders for path in sorted(folder.rglob("*.wms"))]
    tour = "".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs/guides").glob("*.md")))
    found += re.findall(r"^```wms(?: \w+)?\n(.*?)^```$", tour, re.MULTILINE | re.DOTALL)
    found += [example.text for code in CODES for example in (page(code).wrong, page(code).right)]
    return (*found, MESHES)


@cache
def _vocabulary() -> dict[str, tuple[str, ...]]:
    """Return the words of all texts by terminal, with repetition."""
    found: dict[str, list[str]] = defaultdict(list)
    for text in texts():
        for token in tokens_and_comments(text):
            found[token.type].append(token.text)
    return {kind: tuple(said) for kind, said in found.items()}


def _words(rng: random.Random) -> str:
    kinds = sorted(_vocabulary())
    some = (rng.choice(ODD if rng.random() < 0.2 else _vocabulary()[rng.choice(kinds)]) for _ in range(60))
    return " ".join(list(some)[: rng.randint(0, 60)])


# ---------------------------------------------------------------- damage


def _damaged(rng: random.Random) -> str:
    text = rng.choice(texts())
    for _ in range(rng.choice([1, 1, 2, 3, 5, 9])):
        text = _hit(text, rng)
    return text


def _hit(text: str, rng: random.Random) -> str:
    i = rng.randint(0, len(text))
    j = min(len(text), i + rng.choice([0, 1, 3, 10, 40]))
    match rng.randint(0, 5):
        case 0:
            return text[:i] + rng.choice(ODD) + text[j:]
        case 1:
            return text[:i] + text[j:]
        case 2:
            return text[:j] + text[i:j] * rng.choice([1, 2, 20]) + text[j:]
        case 3:
            return text[:i] + chr(rng.choice([rng.randint(0, 127), rng.randint(0, 0xD7FF)])) + text[i:]
        case 4:
            said = text.split(" ")
            said[rng.randrange(len(said))] = rng.choice(rng.choice(list(_vocabulary().values())))
            return " ".join(said)
        case _:
            lines = text.split("\n")
            k = rng.randrange(len(lines))
            lines.insert(rng.randint(0, len(lines)), lines[k] if rng.random() < 0.5 else lines.pop(k))
            return "\n".join(lines)


# ---------------------------------------------------------------- crossing


def _crossed(rng: random.Random) -> str:
    """Return a spec with some nodes replaced by those of another, repeated, removed, or extreme numbers."""
    text = rng.choice(texts())
    own = _nodes(text)
    edits: list[tuple[Span, str]] = []
    for _ in range(rng.choice([1, 1, 1, 1, 2, 3]) if own else 0):
        kind = rng.choice(sorted(own))
        span = rng.choice(own[kind])
        if all(span.end <= other.start or other.end <= span.start for other, _ in edits):
            edits.append((span, _instead(kind, span, rng, own if rng.random() < 0.7 else _nodes(rng.choice(texts())))))
    for span, new in sorted(edits, key=lambda e: -e[0].start):
        text = text[: span.start] + new + text[span.end :]
    return text


def _instead(kind: str, span: Span, rng: random.Random, donor: dict[str, list[Span]]) -> str:
    if kind == "Number" and rng.random() < 0.5:
        return rng.choice(NUMBERS) + " " + span.text.lstrip("0123456789.eE")
    other: str = rng.choice(donor.get(kind, [span])).text
    return rng.choices((other, f"{span.text} {other}", ""), (8, 2, 1))[0]


@cache
def _nodes(text: str) -> dict[str, list[Span]]:
    """Return the spans of a text's syntax nodes by kind. Expressions other than names share one kind."""
    found: dict[str, list[Span]] = defaultdict(list)
    for node in _walk(parse(Source("text", text), Report())):
        if not isinstance(node, s.File | s.Task):
            found[type(node).__name__].append(node.span)
        if isinstance(node, s.Expr) and not isinstance(node, s.Name):
            found["Expr"].append(node.span)
    return dict(found)


def _walk(node: Any) -> Iterator[Any]:
    if isinstance(node, tuple):
        for child in node:
            yield from _walk(child)
    elif is_dataclass(node) and not isinstance(node, Span):
        yield node
        for field in fields(node):
            yield from _walk(getattr(node, field.name))


# ---------------------------------------------------------------- sentences of the grammar


def _grown(rng: random.Random) -> str:
    """Return a task of random statements of the grammar with words of all texts."""
    body = [_sentence("_statement", rng) for _ in range(rng.randint(1, 12))]
    return "use tabletop\ntask grown : custom {\n" + "\n".join(body) + "\n}\n"


@cache
def _grammar() -> tuple[dict[str, list[Rule]], dict[str, int], dict[str, str]]:
    """Return the rules of each symbol, the minimal depth of its trees, and the fixed words of terminals."""
    lark = lark_parser(grammar())
    rules: dict[str, list[Rule]] = defaultdict(list)
    for rule in lark.rules:
        rules[rule.origin.name].append(rule)
    depths: dict[str, int] = {}
    for _ in rules:
        for name, choices in rules.items():
            known = [_depth(rule, depths) for rule in choices]
            depths[name] = min(known)
    return dict(rules), depths, {t.name: t.pattern.value for t in lark.terminals if t.pattern.type == "str"}


def _depth(rule: Rule, depths: dict[str, int]) -> int:
    below = (depths.get(symbol.name, 10**6) for symbol in rule.expansion if isinstance(symbol, NonTerminal))
    return 1 + max(below, default=0)


def _sentence(start: str, rng: random.Random) -> str:
    rules, depths, fixed = _grammar()
    said: list[str] = []
    waiting: list[tuple[Symbol, int]] = [(NonTerminal(start), 0)]
    while waiting:
        symbol, depth = waiting.pop()
        if not isinstance(symbol, NonTerminal):
            said.append(fixed.get(symbol.name) or rng.choice(_vocabulary().get(symbol.name, ("x",))))
            continue
        choices = rules[symbol.name]
        if depth and (len(said) > 60 or rng.random() < 0.8):
            choices = [rule for rule in choices if _depth(rule, depths) == depths[symbol.name]]
        waiting += [(child, depth + 1) for child in reversed(rng.choice(choices).expansion)]
    return " ".join(said)
