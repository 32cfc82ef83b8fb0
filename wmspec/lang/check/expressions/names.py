"""Checks bare names: declarations, `end`, and words of the language."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.core.diagnostics import MAX_LISTED_NAMES, suggestion
from wmspec.lang.check.expressions.typed import Failed, Typed, fits
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import LIBRARY_SHAPES, NOT_RIGID, RIGID_REMEDY, SETS, WORD_ALIASES, WORDS
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

#: Types of the values that blocks declare.
BLOCKS: dict[str, Type] = {
    "object": OBJECT,
    "camera": CAMERA,
    "joint": JOINT,
    "robot": ROBOT,
    "light": LIGHT,
    "world": WORLD,
}


def name(check: Expressions, e: s.Name, expected: tuple[Type, ...]) -> Typed:
    """Resolve a name. Declarations take precedence over words, unless only the word has an expected type."""
    if not e.id:  # a missing name was reported
        raise Failed
    word = _word(e.id, expected)
    declared = None if e.closed else check.scope.names.get(e.id)
    if declared is not None:
        typed = _declared(check, e, declared)
        if word is None or any(fits(typed.type, k) for k in expected):
            return typed
        check.words.add((e.span.source.name, e.span.start))
        return word
    if e.id == "end":
        return Typed(ir.Ref(name="end"), A_TIME)
    if e.id == "index":
        check.fail("WMS201", "`index` is known only in a set, `objects NAME[NUMBER] { ... }`", e.span)
    found_word = word or _word(e.id, tuple(Word(vocabulary) for vocabulary in WORDS))
    if found_word is not None:
        return found_word
    check.unknown(e, f"`{e.id}` is not known here", suggest(check, e.id, expected))


def may_be_undeclared_name(check: Expressions, e: s.Expr, given: Type) -> bool:
    """Whether an expression is a word of the language that may be meant as a declared name."""
    return isinstance(e, s.Name) and isinstance(given, Word) and e.id not in check.scope.names


def _declared(check: Expressions, e: s.Name, declared: Declaration) -> Typed:
    match declared:
        case s.Factor(count=count) | s.Action(count=count) if count is not None:
            return check.all_of(e, declared)
        case s.Factor():
            made = check.memoized(("factor", e.id), e.span, lambda: Typed(ir.Ref(name=e.id), check.domain_of(declared)))
            return Typed(ir.Ref(name=e.id), made.type)
        case s.Let():
            made = check.memoized(("let", e.id), e.span, lambda: check.infer(declared.value))
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
    """Return the present members of a set."""
    everyone = ir.Items(items=tuple(ir.Value(value=m) for m in members))
    return ir.Call(function="present", arguments=(everyone,))


def _word(word: str, expected: tuple[Type, ...]) -> Typed | None:
    """Return the word if it belongs to an expected vocabulary."""
    for kind in expected:
        item = kind.item if isinstance(kind, List) else kind
        vocabulary = NEITHER if item == LABEL else item
        if isinstance(vocabulary, Word) and word in WORDS[vocabulary.vocabulary]:
            return Typed(ir.Value(value=word), vocabulary)
    return None


def suggest(check: Expressions, name: str, expected: tuple[Type, ...]) -> str:
    """Return a suggestion for a name: first names of the expected types, then all others."""
    if known := _known_mistake(check, name, expected):
        return known
    fit, values = names_of_types(check, expected), check.scope.of(s.Factor, s.Let)
    if (other := WORD_ALIASES.get(name)) in fit:
        return f"did you mean `{other}`?"
    named = bool(expected) and all(
        kind in BLOCKS.values() for kind in expected
    )  # no word of the language has these types
    groups = [[w for w in group if w != name] for group in (fit, values, [] if named else check.scope.known())]
    help = suggestion(name, *groups)
    if Word("color") in expected and not help.startswith("did you mean"):
        return "write a word such as `red` or `green`, or `rgb(100 %, 80 %, 0 %)`"
    return help


def _known_mistake(check: Expressions, name: str, expected: tuple[Type, ...]) -> str:
    """Return the remedy for a name of something that wmspec lacks, or of a property without its owner, or ''."""
    if name in NOT_RIGID:
        return RIGID_REMEDY
    if name in ("yes", "no"):
        return f'truth values are `true` and `false`; a text has quotation marks: `"{name}"`'
    if name == "idx":
        return "in a set, `index` is the number of the member, from 0"
    if name in LIBRARY_SHAPES:
        return f"`{name}` is a library: write `use {name} as NAME`"
    owners = [] if expected else _owners(check, name)
    return f"did you mean `{owners[0]}.{name}`?" if owners else ""


def _owners(check: Expressions, name: str) -> list[str]:
    """Return the actions with this argument, then the objects with this property."""
    actions, objects = [], []
    for declared in check.scope.names.values():
        if isinstance(declared, s.Action) and isinstance(declared.call, s.Call):
            if any(argument.name is not None and argument.name.id == name for argument in declared.call.arguments):
                actions.append(declared.name.id)
        elif isinstance(declared, s.Block) and any(p.name.id == name for p in declared.properties):
            objects.append(declared.name.id)
    return [owner for owner in (*actions, *objects) if owner not in check.scope.sets]


def suggest_replacement(check: Expressions, e: s.Name, expected: tuple[Type, ...]) -> str:
    """Return a suggestion for a name whose value has none of the expected types."""
    names = names_of_types(check, tuple(k for k in expected if k != TRUTH and not isinstance(k, List)))
    if e.id in check.scope.names:  # correctly spelled
        return f"known here: {', '.join(sorted(set(names)))}" if 0 < len(names) <= MAX_LISTED_NAMES else ""
    return suggestion(e.id, names)


def names_of_types(check: Expressions, expected: tuple[Type, ...]) -> list[str]:
    """Return the words and names that have an expected type in every instance."""
    items = [k.item if isinstance(k, List) else k for k in expected]
    words = [w for k in items if isinstance(k, Word) for w in WORDS.get(k.vocabulary, ())]
    words += ["true", "false"] if TRUTH in items else []
    for block, kind in BLOCKS.items():
        if kind in items or (kind == OBJECT and LABEL in items):
            words += check.scope.blocks(block)
    for sets, block in SETS.items():
        if BLOCKS[block] in items or (sets == "objects" and LABEL in items):
            words += check.scope.blocks(sets)
    return [*words, *(check.scope.of(s.Action) if ACTION in items else ())]
