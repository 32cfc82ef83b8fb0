"""The input that the grammar and the checker expect at a place: types of values, properties, arguments, names."""

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
from wmspec.lang.check.tables.property_schema import allowed_properties, entity_type
from wmspec.lang.check.tables.verbs import ROBOTS, VERBS, Verb
from wmspec.lang.check.tables.vocabulary import (
    DESIGNS,
    FACTOR_DIMENSIONS,
    JOINTS,
    LEGIBILITY,
    PROPERTIES,
    SETS,
    SETTINGS,
    TOLERANCES,
    PropertySpec,
)
from wmspec.lang.check.types.types import (
    A_LENGTH,
    A_NUMBER,
    A_TIME,
    ACTION,
    CHANNEL,
    OBJECT,
    PLACE,
    POINT2,
    TRUTH,
    List,
    Quantity,
    Type,
    Vector,
)
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.lr_parser import Symbol, Tree
from wmspec.lang.parse.parser import parse_expression

_BLOCKS = {kind.upper(): kind for kind in (*PROPERTIES, *SETS)} | {"TEMPLATE": "object"}
_OPEN = ("LPAR", "LSQB", "LBRACE")


@dataclass(frozen=True)
class ExpectedInput:
    """The expected input at a place.

    `types` are those of an expected value; None for any type, empty for no value. `measured`: whether the value may
    depend on the executed episode. `slots` are properties or arguments that may follow, each with a colon. `kind`
    restricts names: "library", "template", "camera", "factor", "verb", "table" (of `words`, each with its meaning), or
    "member" of the expression `of`.
    """

    types: tuple[Type, ...] | None = ()
    measured: bool = False
    slots: Mapping[str, PropertySpec] = field(default_factory=dict)
    kind: str = ""
    words: Mapping[str, str] = field(default_factory=dict)
    of: Span | None = None


ANYTHING = ExpectedInput(types=None)
#: What is expected after symbols that decide it alone.
_FIXED: dict[str, ExpectedInput] = {
    **dict.fromkeys(("IF", "AND", "OR", "NOT", "REQUIRE", "ENSURE", "WHEN"), ExpectedInput((TRUTH,))),
    **dict.fromkeys(("REPEAT", "OF", "STABLE"), ExpectedInput((A_NUMBER,))),
    **dict.fromkeys(("HORIZON", "FOR"), ExpectedInput((A_TIME,))),
    **dict.fromkeys(("AFTER", "WITH"), ExpectedInput((ACTION,))),
    **dict.fromkeys(("HIDE", "SEEN"), ExpectedInput((OBJECT, List(OBJECT)))),
    **dict.fromkeys(("WITHOUT", "ORDER"), ExpectedInput(kind="changed")),
    "HOLDOUT": ExpectedInput(kind="factor"),
    "USE": ExpectedInput(kind="library"),
    "OBSERVE": ExpectedInput(kind="camera"),
    "ABOUT": ExpectedInput(kind="table", words=FACTOR_DIMENSIONS),
    "LEGIBILITY": ExpectedInput(kind="table", words=LEGIBILITY),
    "DESIGN": ExpectedInput(kind="table", words={name: plan.meaning for name, plan in DESIGNS.items()}),
    "TOLERANCE": ExpectedInput(kind="table", words={name: slot.meaning for name, slot in TOLERANCES.items()}),
}


class Reader:
    """Derives the expected input from the parser's stack."""

    def __init__(self, source: Source, meaning: Expressions | None, stack: tuple[Symbol, ...]) -> None:
        self.source = source
        self.meaning = meaning
        self.stack = stack

    def expected(self) -> ExpectedInput:
        """Return the expected input after the whole stack."""
        context = self._after(len(self.stack) - 1)
        measuring = {"ANSWER", "ENSURE", "MARGIN", "DIFFERENCE", "APART", "UNLESS"} & {symbol(p) for p in self.stack}
        return ExpectedInput(context.types, bool(measuring), context.slots, context.kind, context.words, context.of)

    def _after(self, top: int) -> ExpectedInput:
        """Return the expected input after the symbols up to `top`."""
        if top < 0:
            return ExpectedInput()
        here, below = self._symbol(top), self._symbol(top - 1)
        if here in _FIXED:
            return _FIXED[here]
        match here:
            case "DOT":
                return ExpectedInput(kind="member", of=self._span(top - 1)) if below != "TASK" else ExpectedInput()
            case "COLON":
                return self._after_colon(top)
            case "LPAR" | "LSQB" | "COMMA":
                return self._within(top)
            case "LBRACE":
                return self._body(top)
            case "COMPARE" | "PLUS" | "MINUS" | "__ANON_0":
                return self._like(top - 1) if self._is_value(top - 1) else self._after(top - 1)
            case "TIMES" | "EQUAL" | "ANSWER" | "OPTIONS" | "MARGIN" | "DIFFERENCE" | "WITHIN" | "UNLESS":
                return ExpectedInput(kind="verb") if here == "EQUAL" and self._names_action(top - 1) else ANYTHING
            case "THEN" | "ELSE":
                opened = max(i for i in range(top) if self._symbol(i) == "IF")
                return self._after(opened - 1)
        return self._after_keyword(top)

    def _names_action(self, top: int) -> bool:
        """Whether the symbols up to `top` are the name of an action or of a set of actions."""
        whole = self._symbol(top) == "RSQB" and self._symbol(top - 4) == "ACTIONS"
        return whole or self._symbol(top - 1) == "ACTION"

    def _after_keyword(self, top: int) -> ExpectedInput:  # noqa: C901  a case for each keyword
        here, below = self._symbol(top), self._symbol(top - 1)
        match here:
            case "IN":
                return self._like(top - 1) if self._is_value(top - 1) else ANYTHING
            case "BY":
                if below == "APART":
                    return self._like(top - 2)
                return self._like(top - 1) if self._is_value(top - 1) else ExpectedInput((A_LENGTH,))
            case "AT":
                on = self._symbol(top - 2) == "COLON"
                return ExpectedInput((POINT2, PLACE) if on else (A_TIME, List(A_TIME)))
            case "AS":
                return ExpectedInput((List(CHANNEL),)) if self._symbol(top - 3) == "AT" else ExpectedInput()
            case "ONLY":
                return ExpectedInput(kind="library_names", of=self._span(top - 1))
            case "ACTION" | "STATE" if below.startswith("__counterfactual") or below == "LBRACE":
                changing = any(self._symbol(i) == "COUNTERFACTUAL" for i in range(top))
                return ExpectedInput(kind="changed") if changing else ExpectedInput()
            case "name" if below == "TOLERANCE" and self._text(top) in TOLERANCES:
                return ExpectedInput(TOLERANCES[self._text(top)].types)
        if here.startswith("__") and "star" in here:
            return self._body(top)
        if here.lower() in SETTINGS:
            return ExpectedInput((SETTINGS[here.lower()],))
        return ExpectedInput()

    # ------------------------------------------------------------ after a colon

    def _after_colon(self, top: int) -> ExpectedInput:
        name, before = self._text(top - 1), self._symbol(top - 2)
        if before in ("OBJECT", "OBJECTS"):
            return ExpectedInput(kind="template")
        if before in ("JOINT", "ROBOT"):
            models = JOINTS if before == "JOINT" else {model: ", ".join(verbs) for model, verbs in ROBOTS.items()}
            return ExpectedInput(kind="table", words=models)
        if before == "TASK" or self._symbol(top - 1) == "RSQB":
            return ExpectedInput(kind="template") if before != "TASK" else ExpectedInput()
        if before in ("ACTION", "STATE"):
            return self._like(top - 1)
        opened = self._opened(top - 1)
        if self._symbol(opened) == "LPAR":
            return self._argument(opened, name)
        slot = self._slots(opened, leave=name).get(name)
        return ExpectedInput(slot.types) if slot is not None else ANYTHING

    # ------------------------------------------------------------ within brackets

    def _within(self, top: int) -> ExpectedInput:
        """Return the expected input after an opening bracket or a comma within brackets."""
        if self._symbol(top - 2) == "ORDER":
            return ExpectedInput(kind="changed")
        opened = self._opened(top + 1)
        if opened < 0:
            return ExpectedInput()
        place = self._count(opened, top)
        match self._symbol(opened):
            case "LPAR" if self._is_value(opened - 1) or self._symbol(opened - 1) == "name":
                return self._argument(opened, "", place)
            case "LPAR":
                outer = self._after(opened - 1)
                return ExpectedInput(None if outer.types is None else _parts(outer.types), kind=outer.kind, of=outer.of)
            case "LSQB" if self._is_value(opened - 1) or self._symbol(opened - 1) == "name":
                return ExpectedInput((A_NUMBER,))
            case "LSQB":
                outer = self._after(opened - 1)
                return ExpectedInput(None if outer.types is None else _items(outer.types), kind=outer.kind, of=outer.of)
        return ExpectedInput()

    def _argument(self, opened: int, name: str, place: int = 0) -> ExpectedInput:
        """Return the expected argument of the call before a bracket, by name or by position."""
        called = self._text(opened - 1)
        if self._symbol(opened - 1) == "name":  # the parameters of a library or a template
            return ANYTHING
        if (verb := self.verb(called)) is not None:
            arguments = dict(verb.arguments)
            if name:
                return ExpectedInput(arguments[name].types) if name in arguments else ANYTHING
            types = tuple(arguments.values())[place].types if place < len(arguments) else ()
            rest = dict(tuple(arguments.items())[place:])
            return ExpectedInput(types, slots=rest)
        if (function := FUNCTIONS.get(called)) is not None:
            if name:
                return ExpectedInput((function.options[name],)) if name in function.options else ANYTHING
            options = {option: PropertySpec((kind,), "") for option, kind in function.options.items()}
            parameters = function.parameters
            if place >= len(parameters):
                return ExpectedInput(parameters[-1:] if function.repeated else (), slots=options)
            return ExpectedInput(_open(parameters[place]), slots=options if place else {})
        return ANYTHING

    def verb(self, called: str) -> Verb | None:
        """Return the verb with this name, of an object or of a robot."""
        robot, dot, name = called.partition(".")
        if not dot:
            return VERBS.get(called) if any(symbol(p) == "ACTION" for p in self.stack) else None
        block = self.meaning.scope.names.get(robot) if self.meaning else None
        if isinstance(block, s.Block) and block.kind == "robot" and block.model is not None:
            return ROBOTS.get(block.model.id, {}).get(name)
        return None

    # ------------------------------------------------------------ within braces

    def _body(self, top: int) -> ExpectedInput:
        """Return the expected properties within the braces of a block."""
        opened = self._opened(top + 1)
        return ExpectedInput(slots=self._slots(opened)) if self._symbol(opened) == "LBRACE" else ExpectedInput()

    def _slots(self, opened: int, leave: str = "") -> dict[str, PropertySpec]:
        """Return the properties of a block that are not written yet, and the one named `leave`."""
        head = next((i for i in range(opened - 1, -1, -1) if self._symbol(i) in (*_BLOCKS, *_OPEN)), -1)
        if head < 0 or self._symbol(head) not in _BLOCKS:
            return {}
        kind = _BLOCKS[self._symbol(head)]
        kind = SETS.get(kind, kind)
        present, parts = self._written_properties(opened)
        model = next((self._text(i) for i in range(head, opened) if self._symbol(i) == "model"), "").lstrip(": \t\n")
        template = self.meaning.scope.names.get(model) if self.meaning else None
        own: dict[str, PropertySpec] = {}
        if isinstance(template, s.Template):
            own = {
                p.name.id: PropertySpec(self._of(p.value), f"of `{model}`", p.value.span.text)
                for p in template.parameters
            }
            parts = parts or bool(template.parts)
        elif kind == "object" and self._symbol(head) in ("OBJECT", "OBJECTS") and model:
            parts = True
        table = own | allowed_properties(entity_type(kind, present, model if kind == "joint" else "", parts))
        return {name: slot for name, slot in table.items() if name not in present or name == leave}

    def _written_properties(self, opened: int) -> tuple[set[str], bool]:
        """Return the names of the properties written within these braces, and whether there are parts."""
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

    def _like(self, at: int) -> ExpectedInput:
        """Return the expected input that has the type of the value there."""
        span = self._span(at)
        expression = parse_expression(span, Report()) if span is not None else None
        types = self._of(expression) if expression is not None else ()
        return ExpectedInput(types or None)

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
        """Whether the symbol there is an expression."""
        return self._symbol(at) in _VALUES

    def _opened(self, top: int) -> int:
        """Return the index of the innermost open bracket before `top`; -1 if there is none."""
        return next((i for i in range(top - 1, -1, -1) if self._symbol(i) in _OPEN), -1)

    def _count(self, opened: int, top: int) -> int:
        """Return the number of values since a bracket."""
        count = 0
        for part in self.stack[opened + 1 : top]:
            if isinstance(part.read, Tree) and part.read.rule.startswith("__"):
                count += sum(isinstance(child, Tree) for child in part.read.children)
            elif isinstance(part.read, Tree):
                count += 1
        return count


#: Rules of expressions whose value may precede an operator or a bracket.
_VALUES = frozenset(
    {"reference", "member", "index", "call", "number", "quantity", "text", "true", "false", "tuple", "list"}
    | {"binary", "minus", "compare", "negate", "both", "either", "range_", "steps", "points", "conditional"}
)


def _open(expected: Type) -> tuple[Type, ...] | None:
    """Return a type of the function tables; None for a generic one."""
    return None if str(expected) in ("quantity", "list of items", "item") else (expected,)


def _parts(types: tuple[Type, ...]) -> tuple[Type, ...]:
    """Return the types of a tuple's components."""
    return tuple(Quantity(t.dimension) if isinstance(t, Vector) else t for t in types)


def _items(types: tuple[Type, ...]) -> tuple[Type, ...] | None:
    """Return the types of a list's items, or of a domain's values."""
    items = tuple(t.item for t in types if isinstance(t, List) and t.item is not None)
    return items or types or None
