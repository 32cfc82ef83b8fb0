"""Bare names: what was declared, `end`, and the words of the language."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.core.diagnostics import FEW, suggestion
from wmspec.lang.check.expressions.typed import Failed, Typed, fits
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import SETS, SYNONYMS, WORDS
from wmspec.lang.check.types.types import (
    A_TIME,
    ACTION,
    CAMERA,
    JOINT,
    LABEL,
    LIGHT,
    NEITHER,
    OBJECT,
    ROBOT,
    TRUTH,
    WORLD,
    List,
    Type,
    Word,
)
from wmspec.lang.parse import syntax as s

if TYPE_CHECKING:
    from wmspec.lang.check.expressions.expressions import Expressions
    from wmspec.lang.check.expressions.scope import Declaration

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
    if not e.id:  # it is missing, and that was reported
        raise Failed
    word = _word(e.id, wanted)
    declared = None if e.closed else check.scope.names.get(e.id)
    if declared is not None:
        typed = _declared(check, e, declared)
        return typed if word is None or any(fits(typed.type, k) for k in wanted) else word
    if e.id == "end":
        return Typed(ir.Ref(name="end"), A_TIME)
    if e.id == "index":
        check.fail("WMS201", "`index` is known only in a set, `objects NAME[NUMBER] { ... }`", e.span)
    found_word = word or _word(e.id, tuple(Word(vocabulary) for vocabulary in WORDS))
    if found_word is not None:
        return found_word
    check.unknown(e, f"`{e.id}` is not known here", suggest(check, e.id, wanted))


def undeclared(check: Expressions, e: s.Expr, given: Type) -> bool:
    """Whether an expression is a word of the language that may have been meant as the name of something."""
    return isinstance(e, s.Name) and isinstance(given, Word) and e.id not in check.scope.names


def _declared(check: Expressions, e: s.Name, declared: Declaration) -> Typed:
    match declared:
        case s.Factor():
            made = check.once(("factor", e.id), e.span, lambda: Typed(ir.Ref(name=e.id), check.domain_of(declared)))
            return Typed(ir.Ref(name=e.id), made.type)
        case s.Let():
            made = check.once(("let", e.id), e.span, lambda: check.infer(declared.value))
            return Typed(ir.Ref(name=e.id), made.type)
        case s.Block(kind=kind) if kind in SETS:
            return Typed(present(check.scope.members(e.id)), List(BLOCKS[SETS[kind]]))
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


def suggest(check: Expressions, name: str, wanted: tuple[Type, ...]) -> str:
    """What may have been meant by a name where types of values are wanted: first what is of these, then all else."""
    fit, values = fitting(check, wanted), check.scope.of(s.Factor, s.Let)
    if (other := SYNONYMS.get(name)) in fit:
        return f"did you mean `{other}`?"
    named = bool(wanted) and all(kind in BLOCKS.values() for kind in wanted)  # what no word of the language is
    groups = [[w for w in group if w != name] for group in (fit, values, [] if named else check.scope.known())]
    return suggestion(name, *groups)


def instead(check: Expressions, e: s.Name, wanted: tuple[Type, ...]) -> str:
    """What may be meant by a name of something that is of none of the types that are wanted."""
    names = fitting(check, tuple(k for k in wanted if k != TRUTH and not isinstance(k, List)))
    if e.id in check.scope.names:  # it is not misspelled
        return f"known here: {', '.join(sorted(set(names)))}" if 0 < len(names) <= FEW else ""
    return suggestion(e.id, names)


def fitting(check: Expressions, wanted: tuple[Type, ...]) -> list[str]:
    """The words and names that are of one of these types whatever the instance."""
    items = [k.item if isinstance(k, List) else k for k in wanted]
    words = [w for k in items if isinstance(k, Word) for w in WORDS.get(k.vocabulary, ())]
    words += ["true", "false"] if TRUTH in items else []
    for block, kind in BLOCKS.items():
        if kind in items or (kind == OBJECT and LABEL in items):
            words += check.scope.blocks(block)
    for sets, block in SETS.items():
        if BLOCKS[block] in items or (sets == "objects" and LABEL in items):
            words += check.scope.blocks(sets)
    return [*words, *(check.scope.of(s.Action) if ACTION in items else ())]
