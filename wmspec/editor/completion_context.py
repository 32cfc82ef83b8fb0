"""What is wanted at a place: values of which types, a property, an argument, a name of what kind."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field

from wmspec.core.diagnostics import Report
from wmspec.core.places import Source, Span
from wmspec.editor.cursor import symbol
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import Failed
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.tables.property_schema import slots, thing_type
from wmspec.lang.check.tables.verbs import ROBOTS, VERBS, Verb
from wmspec.lang.check.tables.vocabulary import JOINTS, PLANS, PROPERTIES, SETS, SETTINGS, TOLERANCES, Slot
from wmspec.lang.check.types.types import (
    A_LENGTH,
    A_NUMBER,
    A_TIME,
    ACTION,
    CHANNEL,
    PLACE,
    POINT2,
    TRUTH,
    List,
    Quantity,
    Type,
    Vector,
)
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.machine import Part, Tree
from wmspec.lang.parse.parser import parse_expression

_BLOCKS = {kind.upper(): kind for kind in (*PROPERTIES, *SETS)} | {"TEMPLATE": "object"}
_OPEN = ("LPAR", "LSQB", "LBRACE")
_TYPED: dict[str, tuple[Type, ...]] = {
    "IF": (TRUTH,),
    "AND": (TRUTH,),
    "OR": (TRUTH,),
    "NOT": (TRUTH,),
    "REQUIRE": (TRUTH,),
    "ENSURE": (TRUTH,),
    "HORIZON": (A_TIME,),
    "REPEAT": (A_NUMBER,),
    "OF": (A_NUMBER,),
    "FOR": (A_TIME,),
    "AFTER": (ACTION,),
    "WITH": (ACTION,),
    "STABLE": (A_NUMBER,),
}


@dataclass(frozen=True)
class Wanted:
    """What is wanted. `types` None: a value of any type, and no types: no value. `measured`: of the executed episode.

    `slots` are properties or arguments that may be named there, each followed by a colon. `kind` is what is named, if
    only such a name fits: "library", "template", "camera", "verb", "table" (of `words`, each with its meaning), or
    "member" of the expression `of`.
    """

    types: tuple[Type, ...] | None = ()
    measured: bool = False
    slots: Mapping[str, Slot] = field(default_factory=dict)
    kind: str = ""
    words: Mapping[str, str] = field(default_factory=dict)
    of: Span | None = None


ANYTHING = Wanted(types=None)


class Reader:
    """Reads a stack of the parser from its top."""

    def __init__(self, source: Source, meaning: Expressions | None, stack: tuple[Part, ...]) -> None:
        self.source = source
        self.meaning = meaning
        self.stack = stack

    def wanted(self) -> Wanted:
        """What is wanted after the whole stack."""
        context = self._after(len(self.stack) - 1)
        asked = {"ANSWER", "ENSURE", "MARGIN", "DIFFERENCE", "APART", "UNLESS"} & {symbol(p) for p in self.stack}
        return Wanted(context.types, bool(asked), context.slots, context.kind, context.words, context.of)

    def _after(self, top: int) -> Wanted:
        """What is wanted after the parts up to `top`."""
        if top < 0:
            return Wanted()
        here, below = self._symbol(top), self._symbol(top - 1)
        if here in _TYPED:
            return Wanted(_TYPED[here])
        match here:
            case "DOT":
                return Wanted(kind="member", of=self._span(top - 1)) if below != "TASK" else Wanted()
            case "COLON":
                return self._after_colon(top)
            case "LPAR" | "LSQB" | "COMMA":
                return self._within(top)
            case "LBRACE":
                return self._body(top)
            case "COMPARE" | "PLUS" | "MINUS" | "__ANON_0":
                return self._like(top - 1) if self._is_value(top - 1) else self._after(top - 1)
            case "TIMES" | "EQUAL" | "ANSWER" | "OPTIONS" | "MARGIN" | "DIFFERENCE" | "WITHIN" | "UNLESS":
                return Wanted(kind="verb") if here == "EQUAL" and self._symbol(top - 2) == "ACTION" else ANYTHING
            case "THEN" | "ELSE":
                opened = max(i for i in range(top) if self._symbol(i) == "IF")
                return self._after(opened - 1)
        return self._after_keyword(top)

    def _after_keyword(self, top: int) -> Wanted:  # noqa: C901, PLR0912  a case for each keyword
        here, below = self._symbol(top), self._symbol(top - 1)
        match here:
            case "IN":
                return self._like(top - 1) if self._is_value(top - 1) else ANYTHING
            case "BY":
                if below == "APART":
                    return self._like(top - 2)
                return self._like(top - 1) if self._is_value(top - 1) else Wanted((A_LENGTH,))
            case "AT":
                on = self._symbol(top - 2) == "COLON"
                return Wanted((POINT2, PLACE) if on else (A_TIME, List(A_TIME)))
            case "AS":
                return Wanted((List(CHANNEL),)) if self._symbol(top - 3) == "AT" else Wanted()
            case "USE":
                return Wanted(kind="library")
            case "ONLY":
                return Wanted(kind="library_names", of=self._span(top - 1))
            case "OBSERVE":
                return Wanted(kind="camera")
            case "WITHOUT" | "ORDER":
                return Wanted(kind="changed")
            case "ACTION" | "STATE" if below.startswith("__counterfactual") or below == "LBRACE":
                changing = any(self._symbol(i) == "COUNTERFACTUAL" for i in range(top))
                return Wanted(kind="changed") if changing else Wanted()
            case "DESIGN":
                return Wanted(kind="table", words={name: plan.meaning for name, plan in PLANS.items()})
            case "TOLERANCE":
                return Wanted(kind="table", words={name: slot.meaning for name, slot in TOLERANCES.items()})
            case "name" if below == "TOLERANCE":
                return Wanted(TOLERANCES[self._text(top)].types) if self._text(top) in TOLERANCES else Wanted()
        if here.startswith("__") and "star" in here:
            return self._body(top)
        if here.lower() in SETTINGS:
            return Wanted((SETTINGS[here.lower()],))
        return Wanted()

    # ------------------------------------------------------------ after a colon

    def _after_colon(self, top: int) -> Wanted:
        name, before = self._text(top - 1), self._symbol(top - 2)
        if before in ("OBJECT", "OBJECTS"):
            return Wanted(kind="template")
        if before in ("JOINT", "ROBOT"):
            models = JOINTS if before == "JOINT" else {model: ", ".join(verbs) for model, verbs in ROBOTS.items()}
            return Wanted(kind="table", words=models)
        if before == "TASK" or self._symbol(top - 1) == "RSQB":
            return Wanted(kind="template") if before != "TASK" else Wanted()
        if before in ("ACTION", "STATE"):
            return self._like(top - 1)
        opened = self._opened(top - 1)
        if self._symbol(opened) == "LPAR":
            return self._argument(opened, name)
        slot = self._slots(opened, leave=name).get(name)
        return Wanted(slot.types) if slot is not None else ANYTHING

    # ------------------------------------------------------------ within brackets

    def _within(self, top: int) -> Wanted:
        """After an opening bracket, or after a comma within brackets."""
        if self._symbol(top - 2) == "ORDER":
            return Wanted(kind="changed")
        opened = self._opened(top + 1)
        if opened < 0:
            return Wanted()
        place = self._count(opened, top)
        match self._symbol(opened):
            case "LPAR" if self._is_value(opened - 1) or self._symbol(opened - 1) == "name":
                return self._argument(opened, "", place)
            case "LPAR":
                outer = self._after(opened - 1)
                return Wanted(None if outer.types is None else _parts(outer.types))
            case "LSQB" if self._is_value(opened - 1) or self._symbol(opened - 1) == "name":
                return Wanted((A_NUMBER,))
            case "LSQB":
                outer = self._after(opened - 1)
                return Wanted(None if outer.types is None else _items(outer.types), kind=outer.kind, of=outer.of)
        return Wanted()

    def _argument(self, opened: int, name: str, place: int = 0) -> Wanted:
        """An argument of what is called before a bracket: the one of that name, or the one at that place."""
        called = self._text(opened - 1)
        if self._symbol(opened - 1) == "name":  # the parameters of a library or a template
            return ANYTHING
        if (verb := self.verb(called)) is not None:
            arguments = dict(verb.arguments)
            if name:
                return Wanted(arguments[name].types) if name in arguments else ANYTHING
            types = tuple(arguments.values())[place].types if place < len(arguments) else ()
            rest = dict(tuple(arguments.items())[place:])
            return Wanted(types, slots=rest)
        if (function := FUNCTIONS.get(called)) is not None:
            if name:
                return Wanted((function.options[name],)) if name in function.options else ANYTHING
            options = {option: Slot((kind,), "") for option, kind in function.options.items()}
            parameters = function.parameters
            if place >= len(parameters):
                return Wanted(parameters[-1:] if function.repeated else (), slots=options)
            return Wanted(_open(parameters[place]), slots=options if place else {})
        return ANYTHING

    def verb(self, called: str) -> Verb | None:
        """The verb that is written so, of an object or of a robot."""
        robot, dot, name = called.partition(".")
        if not dot:
            return VERBS.get(called) if any(symbol(p) == "ACTION" for p in self.stack) else None
        block = self.meaning.scope.names.get(robot) if self.meaning else None
        if isinstance(block, s.Block) and block.kind == "robot" and block.model is not None:
            return ROBOTS.get(block.model.id, {}).get(name)
        return None

    # ------------------------------------------------------------ within braces

    def _body(self, top: int) -> Wanted:
        """Within the braces of a block: its properties."""
        opened = self._opened(top + 1)
        return Wanted(slots=self._slots(opened)) if self._symbol(opened) == "LBRACE" else Wanted()

    def _slots(self, opened: int, leave: str = "") -> dict[str, Slot]:
        """The properties of the block with these braces that are not said yet; `leave` in the one that is."""
        head = next((i for i in range(opened - 1, -1, -1) if self._symbol(i) in (*_BLOCKS, *_OPEN)), -1)
        if head < 0 or self._symbol(head) not in _BLOCKS:
            return {}
        kind = _BLOCKS[self._symbol(head)]
        kind = SETS.get(kind, kind)
        present, parts = self._written_properties(opened)
        model = next((self._text(i) for i in range(head, opened) if self._symbol(i) == "model"), "").lstrip(": \t\n")
        template = self.meaning.scope.names.get(model) if self.meaning else None
        own: dict[str, Slot] = {}
        if isinstance(template, s.Template):
            own = {p.name.id: Slot(self._of(p.value), f"of `{model}`", p.value.span.text) for p in template.parameters}
            parts = parts or bool(template.parts)
        elif kind == "object" and self._symbol(head) in ("OBJECT", "OBJECTS") and model:
            parts = True
        table = own | slots(thing_type(kind, present, model if kind == "joint" else "", parts))
        return {name: slot for name, slot in table.items() if name not in present or name == leave}

    def _written_properties(self, opened: int) -> tuple[set[str], bool]:
        """The names of the properties within these braces so far, and whether there are parts."""
        names, parts = set[str](), False
        for part in self.stack[opened + 1 :]:
            trees = [part.read] if isinstance(part.read, Tree) else []
            trees = [c for t in trees for c in (t.children if t.rule.startswith("__") else [t]) if isinstance(c, Tree)]
            for tree in trees:
                if tree.rule == "property":
                    name = tree.children[0]
                    names.add(self.source.text[name.start : name.end])
                parts = parts or tree.rule == "part"
        return names, parts

    # ------------------------------------------------------------ types of what was read

    def _like(self, at: int) -> Wanted:
        """What goes with the value there: one of its types."""
        span = self._span(at)
        expression = parse_expression(span, Report()) if span is not None else None
        types = self._of(expression) if expression is not None else ()
        return Wanted(types or None)

    def _of(self, expression: s.Expr) -> tuple[Type, ...]:
        if self.meaning is None:
            return ()
        with suppress(Failed):
            return (self.meaning.measuring(expression).type,)
        return ()

    # ------------------------------------------------------------ the stack

    def _symbol(self, at: int) -> str:
        return symbol(self.stack[at]) if 0 <= at < len(self.stack) else ""

    def _span(self, at: int) -> Span | None:
        if not 0 <= at < len(self.stack):
            return None
        part = self.stack[at]
        return Span(self.source, int(part.start), part.end)

    def _text(self, at: int) -> str:
        span = self._span(at)
        return span.text if span else ""

    def _is_value(self, at: int) -> bool:
        """Whether an expression was read there."""
        return self._symbol(at) in _VALUES

    def _opened(self, top: int) -> int:
        """Where the innermost bracket before `top` was opened; -1 if none was."""
        return next((i for i in range(top - 1, -1, -1) if self._symbol(i) in _OPEN), -1)

    def _count(self, opened: int, top: int) -> int:
        """How many values were read since a bracket was opened."""
        count = 0
        for part in self.stack[opened + 1 : top]:
            if isinstance(part.read, Tree) and part.read.rule.startswith("__"):
                count += sum(isinstance(child, Tree) for child in part.read.children)
            elif isinstance(part.read, Tree):
                count += 1
        return count


#: The rules of expressions whose value may stand before an operator or a bracket.
_VALUES = frozenset(
    {"reference", "member", "index", "call", "number", "quantity", "text", "true", "false", "tuple", "list"}
    | {"binary", "minus", "compare", "negate", "both", "either", "range_", "steps", "points", "conditional"}
)


def _open(wanted: Type) -> tuple[Type, ...] | None:
    """A type of the tables of functions; None for one that stands for any."""
    return None if str(wanted) in ("quantity", "list of items", "item") else (wanted,)


def _parts(types: tuple[Type, ...]) -> tuple[Type, ...]:
    """The types of a tuple's parts."""
    return tuple(Quantity(t.dimension) if isinstance(t, Vector) else t for t in types)


def _items(types: tuple[Type, ...]) -> tuple[Type, ...] | None:
    """The types of a list's items; of a domain's, those of its values."""
    items = tuple(t.item for t in types if isinstance(t, List) and t.item is not None)
    return items or types or None
