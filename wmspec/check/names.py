"""Bare names: what was declared, `end`, and the words of the language."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.check import ir
from wmspec.check.typed import Typed, fits
from wmspec.check.types import (
    A_TIME,
    ACTION,
    CAMERA,
    JOINT,
    LABEL,
    LIGHT,
    NEITHER,
    OBJECT,
    ROBOT,
    WORLD,
    List,
    Type,
    Word,
)
from wmspec.check.vocabulary import WORDS
from wmspec.diagnostics import suggestion
from wmspec.parse import syntax as s

if TYPE_CHECKING:
    from wmspec.check.expressions import Expressions
    from wmspec.check.scope import Declaration

#: The kind of what a block declares.
BLOCKS: dict[str, Type] = {
    "object": OBJECT,
    "camera": CAMERA,
    "joint": JOINT,
    "robot": ROBOT,
    "light": LIGHT,
    "world": WORLD,
}


def name(check: Expressions, e: s.Name, wanted: tuple[Type, ...]) -> Typed:
    """What a name stands for. What is declared goes before a word, unless only the word fits what is wanted."""
    word = _word(e.id, wanted)
    declared = check.scope.names.get(e.id)
    if declared is not None:
        found = _declared(check, e, declared)
        return found if word is None or any(fits(found.type, k) for k in wanted) else word
    if e.id == "end":
        return Typed(ir.Ref(name="end"), A_TIME)
    if e.id == "index":
        check.fail("WMS201", "`index` is known only in a set, `objects NAME[NUMBER] { ... }`", e.span)
    found_word = word or _word(e.id, tuple(Word(vocabulary) for vocabulary in WORDS))
    if found_word is not None:
        return found_word
    check.fail("WMS201", f"`{e.id}` is not known here", e.span, _suggest(check, e.id, wanted))


def _declared(check: Expressions, e: s.Name, declared: Declaration) -> Typed:
    match declared:
        case s.Factor():
            made = check.once(("factor", e.id), e.span, lambda: Typed(ir.Ref(name=e.id), check.domain_of(declared)))
            return Typed(ir.Ref(name=e.id), made.type)
        case s.Let():
            made = check.once(("let", e.id), e.span, lambda: check.infer(declared.value))
            return Typed(ir.Ref(name=e.id), made.type)
        case s.Block(kind="objects"):
            return Typed(present(check.scope.members(e.id)), List(OBJECT))
        case s.Block():
            return Typed(ir.Value(value=e.id), BLOCKS[declared.kind])
        case s.Action():
            return Typed(ir.Value(value=e.id), ACTION)
        case s.Template():
            check.fail("WMS302", "a template is not a value", e.span, f"make one: `object NAME : {e.id} {{ ... }}`")


def present(members: tuple[str, ...]) -> ir.Expr:
    """Those members of a set that are there."""
    everyone = ir.Items(items=tuple(ir.Value(value=m) for m in members))
    return ir.Call(function="present", arguments=(everyone,))


def _word(word: str, wanted: tuple[Type, ...]) -> Typed | None:
    """The word as one of the vocabularies that are wanted."""
    for kind in wanted:
        item = kind.item if isinstance(kind, List) else kind
        vocabulary = NEITHER if item == LABEL else item
        if isinstance(vocabulary, Word) and word in WORDS[vocabulary.vocabulary]:
            return Typed(ir.Value(value=word), vocabulary)
    return None


def _suggest(check: Expressions, name: str, wanted: tuple[Type, ...]) -> str:
    words = [w for k in wanted if isinstance(k, Word) for w in WORDS.get(k.vocabulary, ())]
    for block, kind in BLOCKS.items():
        if kind in wanted or (kind == OBJECT and LABEL in wanted):
            words += check.scope.blocks(block)
    near = words and suggestion(name, [*words, *check.scope.of(s.Factor, s.Let)])
    return near or suggestion(name, check.scope.known())
