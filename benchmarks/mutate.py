"""Quality of diagnostics: specs with one broken word, and the messages of `wmspec check`.

    python -m benchmarks.mutate --count 2500

A mutant passes if there is exactly one error, on the right line (of the broken word, a neighbouring word, or a note),
and, for a misspelling, with the correct word. A mutant is a pure function of its number and of the specs and examples
in the repository. Mutants that are valid specs, such as a misspelled declaration of an unused name, are counted
separately.
"""

from __future__ import annotations

import argparse
import random
import re
import string
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from wmspec.compile.lint.dry_run import dry_run
from wmspec.core.diagnostics import Diagnostic, Report, WmsError
from wmspec.core.places import Source, Span
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.check.tables.vocabulary import WORDS
from wmspec.lang.check.types.units import UNITS
from wmspec.lang.parse.files import library_folder
from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.load import load_source
from wmspec.lang.parse.parser import tokens_and_comments
from wmspec.lang.parse.tables import tables

ROOT = Path(__file__).parent.parent
OPENING, CLOSING = {"LPAR": "(", "LSQB": "[", "LBRACE": "{"}, {"RPAR": ")", "RSQB": "]", "RBRACE": "}"}
#: Kinds of misspellings: the correct word must be suggested.
SPELLED = ("keyword", "name", "declaration", "property", "argument", "verb or function", "word", "library", "unit")


@dataclass(frozen=True)
class Mutant:
    """A text with one mistake: its kind, the accepted lines, and the corrections."""

    kind: str
    text: str
    lines: frozenset[int]
    broken: str
    mend: frozenset[str]


@dataclass(frozen=True)
class Outcome:
    """The errors of a mutant, whether one is on the right line, whether it is corrected, and the seconds."""

    mutant: Mutant
    errors: tuple[Diagnostic, ...]
    located: bool
    fixed: bool
    seconds: float


# ---------------------------------------------------------------- mutants


@dataclass(frozen=True)
class Spec:
    """A valid text with its tokens."""

    text: str
    tokens: tuple[Token, ...]

    def mutant(self, kind: str, i: int, put: str, mend: str = "", start: int = 0, end: int | None = None) -> Mutant:
        """Return the text with characters `start` to `end` of word `i` replaced."""
        token = self.tokens[i]
        a, b = token.start + start, token.end if end is None else token.start + end
        text = self.text[:a] + put + self.text[b:]
        first = self.tokens[i - 1].end_line if i else 1
        last = self.tokens[i + 1].line if i + 1 < len(self.tokens) else token.end_line
        broken = text[token.start : a + len(put) + (token.end - b)]
        expected = {mend, broken} if kind == "declaration" else {mend}
        return Mutant(
            kind, text, frozenset(range(first, last + 1)), f"{token.text!r} as {broken!r}", frozenset(expected - {""})
        )


Maker = Callable[[Spec, random.Random], Iterator[Mutant]]


def misspelled(spec: Spec, rng: random.Random) -> Iterator[Mutant]:
    """Misspell a word."""
    known = {t.text for t in spec.tokens} | {w for group in WORDS.values() for w in group} | set(tables().keywords)
    i = rng.choice([i for i, t in enumerate(spec.tokens) if t.text.isidentifier() and len(t.text) > 2])
    kind, slip = _role(spec.tokens, i), _slip(spec.tokens[i].text, rng)
    if kind and slip not in known:
        yield spec.mutant(kind, i, slip, spec.tokens[i].text)


def capital(spec: Spec, rng: random.Random) -> Iterator[Mutant]:
    """Capitalize a keyword."""
    i = rng.choice([i for i, t in enumerate(spec.tokens) if t.text in tables().keywords])
    if _role(spec.tokens, i) == "keyword":
        yield spec.mutant("keyword", i, spec.tokens[i].text.capitalize(), spec.tokens[i].text)


def other_kind(spec: Spec, rng: random.Random) -> Iterator[Mutant]:
    """Replace a name or word by one of another kind."""
    at = [i for i, t in enumerate(spec.tokens) if t.type == "NAME" and _role(spec.tokens, i) in ("name", "word")]
    if at:
        i = rng.choice(at)
        own = next((group for group in WORDS.values() if spec.tokens[i].text in group), ())
        strange = rng.choice(["cube", "rubber", "red", "straight", "hull"])
        if strange not in own:
            yield spec.mutant("word of another kind", i, strange)


def dropped_keyword(spec: Spec, rng: random.Random) -> Iterator[Mutant]:
    """Remove a keyword."""
    i = rng.choice([i for i, t in enumerate(spec.tokens) if t.text in tables().keywords])
    if _role(spec.tokens, i) == "keyword" and spec.tokens[i].text not in ("not", "if"):
        yield spec.mutant("keyword dropped", i, "")


def unit(spec: Spec, rng: random.Random) -> Iterator[Mutant]:
    """Remove or misspell a unit, or change its dimension."""
    at = [i for i, t in enumerate(spec.tokens) if t.type == "QUANTITY" and "%" not in t.text]
    if not at:
        return
    i = rng.choice(at)
    token = spec.tokens[i]
    number = re.match(r"[\d.]+", token.text)
    assert number
    start = number.end()
    written = token.text[start:].strip()
    how = rng.choice(["missing", "wrong", "unit"])
    if how == "missing" and float(number[0]) != 0:
        yield spec.mutant("unit missing", i, "", start=start)
    elif how == "wrong":
        yield spec.mutant("unit of another dimension", i, " kg^2", start=start)
    elif (slip := _slip(written, rng) if len(written) > 1 else written + written) not in UNITS and slip.isalpha():
        yield spec.mutant("unit", i, f" {slip}", written, start=start)


def bracket(spec: Spec, rng: random.Random) -> Iterator[Mutant]:
    """Remove, repeat or replace a bracket."""
    i = rng.choice([i for i, t in enumerate(spec.tokens) if t.type in OPENING or t.type in CLOSING])
    token = spec.tokens[i]
    others = [b for b in (OPENING if token.type in OPENING else CLOSING).values() if b != token.text]
    how = rng.choice(["dropped", "added", "changed"])
    put = {"dropped": "", "added": token.text * 2, "changed": rng.choice(others)}[how]
    yield spec.mutant(f"bracket {how}", i, put)


def quote(spec: Spec, rng: random.Random) -> Iterator[Mutant]:
    """Remove a quote, or replace it by a typographic one."""
    at = [i for i, t in enumerate(spec.tokens) if t.type == "STRING"]
    if at:
        i = rng.choice(at)
        text = spec.tokens[i].text
        first = rng.random() < 0.5
        yield rng.choice(
            [
                spec.mutant("quote dropped", i, text[1:] if first else text[:-1]),
                spec.mutant("quotes pretty", i, f"“{text[1:-1]}”"),
                spec.mutant("quotes pretty", i, f"“{text[1:]}" if first else f"{text[:-1]}”"),
            ]
        )


def sign(spec: Spec, rng: random.Random) -> Iterator[Mutant]:
    """Remove or replace a colon, comma, equals sign, minus or comparison."""
    puts = {
        "COLON": ["", "="],
        "COMMA": ["", ";"],
        "EQUAL": ["", "=="],
        "MINUS": ["−", "–"],
        "COMPARE": ["="],
        "AND": ["&&"],
        "OR": ["||"],
        "NOT": ["!"],
    }
    i = rng.choice([i for i, t in enumerate(spec.tokens) if t.type in puts])
    token = spec.tokens[i]
    put = rng.choice(puts[token.type])
    if token.text not in ("<=", ">=", "!=") and (put != "" or not _trailing(spec.tokens, i)):
        yield spec.mutant("sign dropped" if put == "" else "sign of another sort", i, put)


def number(spec: Spec, rng: random.Random) -> Iterator[Mutant]:
    """Put a letter or a second point into a number."""
    i = rng.choice([i for i, t in enumerate(spec.tokens) if t.type in ("NUMBER", "QUANTITY")] or [0])
    digits = re.match(r"[\d.]+", spec.tokens[i].text)
    if digits:
        put = rng.choice([digits[0] + "O", digits[0] + "..", "=" + digits[0], digits[0] + ".5.5", digits[0] + "x"])
        yield spec.mutant("number", i, put, end=digits.end())


def hyphen(spec: Spec, rng: random.Random) -> Iterator[Mutant]:
    """Put a hyphen into all occurrences of a name."""
    at = [i for i, t in enumerate(spec.tokens) if t.type == "NAME" and _role(spec.tokens, i) == "declaration"]
    if at:
        i = rng.choice(at)
        name = spec.tokens[i].text
        if re.search(rf"\b{name}\s*:", spec.text):  # a property or argument is called so too
            return
        made = spec.mutant("hyphen", i, f"{name}-x")
        text = re.sub(rf"\b{name}\b", f"{name}-x", spec.text)
        lines = frozenset(n for n, line in enumerate(text.splitlines(), 1) if f"{name}-x" in line)
        yield Mutant("hyphen", text, lines, made.broken, frozenset())


def extra(spec: Spec, rng: random.Random) -> Iterator[Mutant]:
    """Insert a comment, a semicolon or a word of another language."""
    i = rng.randrange(len(spec.tokens) - 1)
    put = rng.choice(["// note", ";", "/* note */", "§", "???"[:1]])
    if spec.tokens[i].end_line < spec.tokens[i + 1].line:
        yield spec.mutant("foreign sign", i, f"{spec.tokens[i].text} {put}")


MAKERS: tuple[tuple[Maker, int], ...] = (
    (misspelled, 10),
    (capital, 1),
    (other_kind, 1),
    (dropped_keyword, 1),
    (unit, 3),
    (bracket, 4),
    (quote, 2),
    (sign, 4),
    (number, 1),
    (hyphen, 1),
    (extra, 1),
)


def _role(tokens: tuple[Token, ...], i: int) -> str:
    """Return the role of a word; "" if its spelling does not matter."""
    before, token = tokens[i - 1] if i else Token("", "", 0, 0), tokens[i]
    after = tokens[i + 1] if i + 1 < len(tokens) else Token("", "", 0, 0)
    if before.type in ("TASK", "QUESTION", "COUNTERFACTUAL", "TOLERANCE", "VARIANT", "AS") or before.type == "DOT":
        return ""
    if before.type == "USE":
        return "library"
    if before.type in ("FACTOR", "NUISANCE", "LET", "OBJECT", "CAMERA", "ACTION", "TEMPLATE", "OBJECTS", "JOINT"):
        return "declaration" if token.text not in tables().keywords else ""
    if before.type in ("LIGHT", "PART", "ROBOT", "PARAMETER"):
        return ""
    if after.type == "COLON":
        depth = _depth(tokens, i)
        return {"(": "argument", "{": "property"}.get(depth, "")
    if token.text in tables().keywords:
        return "keyword"
    if token.type == "SETTING":
        return "keyword"
    if token.type != "NAME" or (before.type == "COLON" and _depth(tokens, i) == ""):
        return ""
    if after.type == "LPAR":
        return "verb or function"
    return "word" if any(token.text in group for group in WORDS.values()) else "name"


def _depth(tokens: tuple[Token, ...], i: int) -> str:
    """Return the bracket around a word."""
    deep = 0
    for token in reversed(tokens[:i]):
        deep += (token.type in CLOSING) - (token.type in OPENING)
        if deep < 0:
            return token.text
    return ""


def _trailing(tokens: tuple[Token, ...], i: int) -> bool:
    return tokens[i + 1].type in CLOSING


def _slip(word: str, rng: random.Random) -> str:
    """Omit, insert, change or swap a letter."""
    i = rng.randrange(len(word) - 1) if len(word) > 1 else 0
    letter = rng.choice(string.ascii_lowercase)
    return rng.choice(
        [
            word[:i] + word[i + 1 : i + 2] + word[i : i + 1] + word[i + 2 :],
            word[: i + 1] + word[i + 2 :] if len(word) > 3 else word[:i] + word[i] + word[i:],
            word[:i] + word[i] + word[i:],
            word[: i + 1] + letter + word[i + 2 :],
        ]
    )


# ---------------------------------------------------------------- outcomes


@cache
def texts() -> tuple[str, ...]:
    """Return the mutated texts: the specs, and the examples of the guides."""
    folder = library_folder()
    shipped = [p.read_text(encoding="utf-8") for p in sorted(folder.parent.rglob("*.wms")) if p.parent != folder]
    tour = "".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs/guides").glob("*.md")))
    examples = re.findall(r"^```wms\n(.*?)^```$", tour, re.MULTILINE | re.DOTALL)
    return (*shipped, *(text for text in examples if not checked(text)))  # what is shipped has no mistakes


@cache
def specs() -> tuple[Spec, ...]:
    """Return the texts with their tokens."""
    return tuple(Spec(text, tuple(t for t in tokens_and_comments(text) if t.type != "COMMENT")) for text in texts())


def checked(text: str, *, scenes: bool = False) -> tuple[Diagnostic, ...]:
    """Return the errors of a spec, without or with those of its scenes."""
    report = Report()
    try:
        for spec in check_program(load_source(Source("mutant.wms", text), ROOT / "docs", report), report):
            if scenes:
                dry_run(spec, report)
    except WmsError as error:
        report.include(error.diagnostics)
    return tuple(d for d in report.diagnostics if d.severity == "error")


def mutant(number: int) -> Mutant:
    """Return mutant `number`, a pure function of it."""
    rng = random.Random(number)  # noqa: S311
    makers, weights = zip(*MAKERS, strict=True)
    while True:
        spec = rng.choice(specs())
        (make,) = rng.choices(makers, weights)
        made = next(make(spec, rng), None)
        if made is not None and made.text != spec.text:
            return made


def outcome(made: Mutant) -> Outcome:
    """Check a mutant."""
    began = time.process_time()
    errors = checked(made.text) or checked(made.text, scenes=True)
    seconds = time.process_time() - began
    located = fixed = False
    if errors:
        places = (errors[0].place, *(note.place for note in errors[0].notes))
        located = any(isinstance(p, Span) and p.source.name == "mutant.wms" and p.line in made.lines for p in places)
        fixed = any(f"`{word}`" in f"{errors[0].help} {errors[0].message}" for word in _mends(made))
    return Outcome(made, errors, located, fixed, seconds)


def _mends(made: Mutant) -> frozenset[str]:
    return frozenset({"apart by"} | made.mend) if made.mend & {"apart", "by"} else made.mend


# ---------------------------------------------------------------- the report


@dataclass
class Tally:
    """Counts of mutants and of passed criteria."""

    count: int = 0
    right: int = 0
    one: int = 0
    located: int = 0
    fixed: int = 0
    slowest: float = 0.0

    def add(self, o: Outcome) -> None:
        """Add an outcome."""
        self.count += 1
        self.slowest = max(self.slowest, o.seconds)
        self.right += not o.errors
        self.one += len(o.errors) == 1
        self.located += o.located
        self.fixed += o.fixed

    def row(self, kind: str) -> str:
        """Return a row of the table."""
        reported = max(1, self.count - self.right)
        shares = [f"{100 * n / reported:6.1f} %" for n in (self.one, self.located)]
        shares.append(f"{100 * self.fixed / reported:6.1f} %" if kind in SPELLED else " " * 8)
        return f"{kind:26} {self.count:6} {self.right:6} {' '.join(shares)} {self.slowest:7.2f} s"


def measured(numbers: range) -> Iterator[Outcome]:
    """Yield the outcomes of these mutants."""
    return (outcome(mutant(number)) for number in numbers)


def main() -> None:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2500)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--show", type=int, default=0, help="Print this many failures of each kind.")
    options = parser.parse_args()
    tallies: dict[str, Tally] = defaultdict(Tally)
    spelled, everything, shown = Tally(), Tally(), defaultdict[str, int](int)
    for o in measured(range(options.first, options.first + options.count)):
        kind = o.mutant.kind
        for tally in (tallies[kind], everything, *([spelled] if kind in SPELLED else [])):
            tally.add(o)
        well = len(o.errors) == 1 and o.located and (o.fixed or kind not in SPELLED)
        if not well and shown[kind] < options.show:
            shown[kind] += 1
            print(f"{kind}: {o.mutant.broken}, lines {sorted(o.mutant.lines)}")
            print(*(f"    {error}" for error in o.errors[:5]) if o.errors else ["    accepted"], sep="\n")
            for line in sorted(o.mutant.lines) if not o.located or len(o.errors) > 1 else ():
                print(
                    f"    | {o.mutant.text.splitlines()[line - 1] if line <= len(o.mutant.text.splitlines()) else ''}"
                )
    print(f"{'kind':26} {'count':>6} {'right':>6} {'one':>8} {'line':>8} {'fixed':>8} {'slowest':>9}")
    for kind in sorted(tallies):
        print(tallies[kind].row(kind))
    print(everything.row("all"))
    reported = max(1, spelled.count - spelled.right)
    print(f"of {reported} misspellings, {100 * spelled.fixed / reported:.1f} % are fixed by the suggestion")


if __name__ == "__main__":
    main()
