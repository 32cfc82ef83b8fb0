"""Completion: the words that fit at a place."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from wmspec.core.diagnostics import Report
from wmspec.core.places import Span
from wmspec.core.safe_io import read_text
from wmspec.editor.completion_context import ExpectedInput, Reader
from wmspec.editor.cursor import Cursor, cursor
from wmspec.editor.document import Document
from wmspec.editor.names import Names
from wmspec.lang.check.expressions.calls import signature
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.names import BLOCKS
from wmspec.lang.check.expressions.typed import Failed, example, fits
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.tables.property_schema import allowed_properties, entity_type
from wmspec.lang.check.tables.verbs import ROBOTS, VERBS, Verb
from wmspec.lang.check.tables.vocabulary import SETS, WORDS, PropertySpec
from wmspec.lang.check.types.types import (
    A_TIME,
    ITEM,
    LABEL,
    QUANTITY,
    TRUTH,
    List,
    Quantity,
    Type,
    Vector,
    Word,
    either,
)
from wmspec.lang.check.types.units import units_of
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.files import library_folder, search_path
from wmspec.lang.parse.lexer import tokenize
from wmspec.lang.parse.parser import parse_expression

ItemKind = Literal["property", "argument", "unit", "name", "function", "verb", "word", "keyword", "library", "part"]
#: The order of the kinds in a list of completions.
ORDER: tuple[ItemKind, ...] = (
    *("unit", "property", "argument", "library", "name", "part", "word", "verb", "function", "keyword"),
)


#: An open `{` in a text: the text before a dot, and the word at its end.
_HOLE = re.compile(r"(?<!\\)\{[^{}\n\"]*?(?:(?P<owner>[A-Za-z_][\w.]*(?:\[\d+\])?)\.)?(?P<word>[A-Za-z_]?\w*)\Z")


@dataclass(frozen=True)
class CompletionItem:
    """A suggested word: its kind, a short detail, its meaning, and the inserted text if that differs."""

    word: str
    sort: ItemKind
    detail: str = ""
    meaning: str = ""
    written: str = ""


@dataclass(frozen=True)
class Completions:
    """The suggestions that replace the characters from `start` on."""

    start: int
    offers: tuple[CompletionItem, ...]


def complete(document: Document, offset: int) -> Completions:
    """Return the suggestions at an offset of a document, the likeliest first."""
    place = cursor(document.text, offset)
    if place is None:
        return _in_text(document, offset)
    meaning = document.meaning(offset)
    if place.unit is not None and (units := _units(document, meaning, place)):
        bare = not document.text[place.unit[0] : offset]  # a keyword may also follow a number
        others = _others(document, meaning, place, offset) if bare and place.start == place.unit[0] else ()
        return Completions(place.unit[0], _sorted([*units, *others]))
    return Completions(place.start, _sorted(_others(document, meaning, place, offset)))


def _in_text(document: Document, offset: int) -> Completions:
    """Return the suggestions inside `{...}` of a text; none elsewhere in a text or a comment."""
    hole = _HOLE.search(document.text[:offset])
    *_, last = tokenize(document.text[:offset])
    if hole is None or last.type != "OPEN_STRING":
        return Completions(offset, ())
    meaning = document.meaning(offset)
    start = offset - len(hole["word"])
    if hole["owner"]:
        of = Span(document.source, hole.start("owner"), hole.end("owner"))
        visible = Names(document).visible(offset).keys()
        return Completions(start, _sorted(_members(meaning, of, visible)))
    return Completions(start, _sorted(_values(document, meaning, ExpectedInput(types=None), offset)))


def _sorted(offers: Iterable[CompletionItem]) -> tuple[CompletionItem, ...]:
    first: dict[str, CompletionItem] = {}
    for offer in sorted(offers, key=lambda o: ORDER.index(o.sort)):
        first.setdefault(offer.word, offer)
    return tuple(first.values())


def _units(document: Document, meaning: Expressions | None, place: Cursor) -> list[CompletionItem]:
    assert place.unit is not None
    types = Reader(document.source, meaning, place.unit[1]).expected().types or ()
    dimensions = dict.fromkeys(t.dimension for each in types if isinstance(t := _item(each), Quantity | Vector))
    return [CompletionItem(unit, "unit", str(dimension)) for dimension in dimensions for unit in units_of(dimension)]


def _item(of: Type) -> Type:
    return of.item if isinstance(of, List) and of.item is not None else of


def _others(document: Document, meaning: Expressions | None, place: Cursor, offset: int) -> Iterator[CompletionItem]:
    expected = Reader(document.source, meaning, place.stack).expected() if place.stack is not None else ExpectedInput()
    yield from (CompletionItem(word, "keyword") for word in place.keywords if _stands(word, expected))
    if place.stack is None:
        return
    arguments = any(p.read is not None and getattr(p.read, "type", "") == "LPAR" for p in place.stack)
    for name, slot in expected.slots.items():
        yield CompletionItem(
            name, "argument" if arguments else "property", accepted_values(slot), slot.meaning, f"{name}: "
        )
    if expected.kind:
        yield from _named(document, meaning, expected, offset)
    elif expected.types is None or expected.types:
        yield from _values(document, meaning, expected, offset)


def _stands(keyword: str, expected: ExpectedInput) -> bool:
    """Whether a keyword that the grammar accepts also fits the expected input."""
    if keyword in ("true", "false", "not") and expected.types is not None:
        return TRUTH in map(_item, expected.types)
    return expected.kind not in ("member", "verb") and not (keyword == "object" and expected.types != ())


def accepted_values(slot: PropertySpec) -> str:
    """Return the types of a property or argument, with its default."""
    kinds = either([str(t) for t in slot.types])
    return f"{kinds}; default: {slot.default}" if slot.default is not None else kinds


# ---------------------------------------------------------------- values


def _values(
    document: Document, meaning: Expressions | None, expected: ExpectedInput, offset: int
) -> Iterator[CompletionItem]:
    types = expected.types
    for name, of, what in _typed(document, meaning, offset):
        if types is None or of is None or any(_may_be(of, t) for t in types):
            yield CompletionItem(name, "name", str(of) if of else what)
    for vocabulary, words in WORDS.items():
        if types is None or any(_item(t) == Word(vocabulary) or (t == LABEL and vocabulary == "tie") for t in types):
            yield from (CompletionItem(word, "word", vocabulary) for word in words)
    if types is not None and A_TIME in map(_item, types):
        yield CompletionItem("end", "word", "time", "when the episode ends")
    for name, function in FUNCTIONS.items():
        if function.measured and not expected.measured:
            continue
        if types is None or any(_may_be(function.result, t) for t in types):
            yield CompletionItem(name, "function", signature(name, function), function.meaning, f"{name}(")


def _may_be(of: Type, expected: Type) -> bool:
    if of in (QUANTITY, ITEM):
        return of == ITEM or isinstance(_item(expected), Quantity)
    return fits(of, expected) or fits(of, _item(expected))


def _typed(document: Document, meaning: Expressions | None, offset: int) -> Iterator[tuple[str, Type | None, str]]:
    """Yield every name in scope with its type, if known, and its kind."""
    for name, declared in Names(document).visible(offset).items():
        node = declared.node
        if isinstance(node, s.Use | s.Template):
            continue
        yield name, _type(meaning, name.replace(".", "_"), node), type(node).__name__.lower()


def _type(meaning: Expressions | None, name: str, node: object) -> Type | None:
    if isinstance(node, s.Block):
        return List(BLOCKS[SETS[node.kind]]) if node.kind in SETS else BLOCKS.get(node.kind)
    if meaning is None or name not in meaning.scope.names:
        return None
    with suppress(Failed):
        span = meaning.scope.names[name].name.span
        return meaning.infer(s.Name(name, span)).type
    return None


# ---------------------------------------------------------------- names of one kind


#: Whether a declaration is of a kind that is expected.
_DECLARED: dict[str, Callable[[Any], bool]] = {
    "template": lambda node: isinstance(node, s.Template),
    "camera": lambda node: isinstance(node, s.Block) and node.kind == "camera",
    "factor": lambda node: isinstance(node, s.Factor) and not node.nuisance,
    "changed": lambda node: isinstance(node, s.Block | s.Action),
}


def _named(  # noqa: C901  one case per kind
    document: Document, meaning: Expressions | None, expected: ExpectedInput, offset: int
) -> Iterator[CompletionItem]:
    visible = Names(document).visible(offset)
    match expected.kind:
        case "table":
            yield from (CompletionItem(word, "word", what) for word, what in expected.words.items())
        case "library":
            yield from _libraries(document.path.parent)
        case "library_names" if expected.of is not None:
            for use, library in document.program.paths.items():
                if use.start == expected.of.start:
                    items = document.program.libraries[library].items
                    named = (i for i in items if isinstance(i, s.Factor | s.Let | s.Block | s.Template | s.Action))
                    yield from (CompletionItem(i.name.id, "name", _what(i)) for i in named)
        case "template" | "camera" | "factor" | "changed":
            for name, declared in visible.items():
                if _DECLARED[expected.kind](declared.node):
                    yield CompletionItem(name, "name", _what(declared.node))
        case "verb":
            yield from _verbs(VERBS, "")
            for name, declared in visible.items():
                node = declared.node
                if isinstance(node, s.Block) and node.kind == "robot" and node.model is not None:
                    yield from _verbs(ROBOTS.get(node.model.id, {}), f"{name}.")
        case "member" if expected.of is not None:
            yield from _members(meaning, expected.of, visible.keys())


def _what(node: object) -> str:
    return node.kind if isinstance(node, s.Block) else type(node).__name__.lower()


def _verbs(verbs: dict[str, Verb], whose: str) -> Iterator[CompletionItem]:
    for name, verb in verbs.items():
        shown = f"{name}({', '.join(verb.arguments)}){' for TIME' if verb.lasts else ''}"
        yield CompletionItem(f"{whose}{name}", "verb", shown, verb.meaning, f"{whose}{name}(")


def _libraries(folder: Path) -> Iterator[CompletionItem]:
    for place in (folder, *search_path(), library_folder()):
        for path in sorted(place.glob("*.wms")):
            with suppress(OSError, UnicodeDecodeError):
                text = read_text(path)
                if "\ntask " not in f"\n{text}":
                    yield CompletionItem(path.stem, "library", text.partition("\n")[0].strip('"'))


def _members(meaning: Expressions | None, of: Span, visible: Iterable[str]) -> Iterator[CompletionItem]:
    """Yield the names after a dot: names of a library, parts and properties of an object, arguments of an action."""
    for name in visible:
        whole, dot, last = name.partition(".")
        if dot and whole == of.text:
            yield CompletionItem(last, "name")
    if meaning is None:
        return
    block = meaning.scope.names.get(of.text.replace(".", "_"))
    if isinstance(block, s.Action):
        call = block.call.function.span.text if isinstance(block.call, s.Call) else ""
        arguments = VERBS[call].arguments if call in VERBS else {}
        yield from (
            CompletionItem(name, "argument", accepted_values(slot), slot.meaning) for name, slot in arguments.items()
        )
        yield CompletionItem("start", "argument", "time", "when it starts")
    elif isinstance(block, s.Block):
        kind = SETS.get(block.kind, block.kind)
        names = {p.name.id for p in block.properties}
        table = allowed_properties(entity_type(kind, names, block.model.id if block.model else "", bool(block.parts)))
        yield from (CompletionItem(part.name.id, "part", "part") for part in block.parts)
        yield from (
            CompletionItem(name, "property", accepted_values(slot), slot.meaning) for name, slot in table.items()
        )
    else:
        expression = parse_expression(of, Report())
        with suppress(Failed):
            type_ = meaning.measuring(expression).type if expression is not None else None
            if isinstance(type_, Vector):
                yield from (CompletionItem(axis, "property", str(type_.dimension)) for axis in "xyz"[: type_.size])


def type_with_example(of: Type) -> str:
    """Return a type with an example value."""
    such = example(of)
    return f"{of}, such as `{such}`" if such and of != TRUTH else str(of)
