"""Syntax tree: the written spec with source spans, before name resolution and checks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal, TypeVar

from wmspec.core.node import Node
from wmspec.core.places import Span

N = TypeVar("N")
#: Types with child nodes.
COMPOSITE_TYPES = (tuple, Node)

# ---------------------------------------------------------------- expressions


class Number(Node):
    """`6 cm`: a number and the text of its unit, if any."""

    value: float
    unit: str | None
    span: Span


class Text(Node):
    """A quoted text, its escapes resolved."""

    value: str
    span: Span


class Pieces(Node):
    """The text of a question: quoted texts, joined by spaces."""

    pieces: tuple[Text, ...]
    span: Span

    @property
    def value(self) -> str:
        """The joined text."""
        return " ".join(piece.value for piece in self.pieces)


class Truth(Node):
    """`true` or `false`."""

    value: bool
    span: Span


class Name(Node):
    """An identifier; `closed` if it belongs to the language, whatever is declared by that name."""

    id: str
    span: Span
    closed: bool = False


class Member(Node):
    """`ball.mass`."""

    value: Expr
    name: Name
    span: Span


class Index(Node):
    """`blocks[2]`: a member of a set of objects or joints."""

    value: Expr
    index: Expr
    span: Span


class Argument(Node):
    """An argument of a call, `name: value` or `value`."""

    name: Name | None
    value: Expr
    span: Span


class Call(Node):
    """`glide(left, speed: 10 cm/s)`."""

    function: Expr
    arguments: tuple[Argument, ...]
    span: Span


class Operation(Node):
    """An operator and its operands: `+ - * / == != < <= > >= and or not if`, `-` also with one operand."""

    operator: str
    operands: tuple[Expr, ...]
    span: Span


class Range(Node):
    """`a .. b`, `a .. b by step`, `a .. b in count`."""

    start: Expr
    stop: Expr
    step: Expr | None
    count: Expr | None
    span: Span


class Items(Node):
    """`[a, b, c] unit` or `(x, y)`."""

    kind: Literal["list", "tuple"]
    items: tuple[Expr, ...]
    unit: str | None
    span: Span


class WhatIf(Node):
    """`value without ball`, `value under state ball.mass: 2 kg`: the value in the episode with one change."""

    value: Expr
    change: Change
    span: Span


class Cause(Node):
    """`cause of condition among [a, b]`: the one of the candidates without which the condition does not hold."""

    condition: Expr
    candidates: Expr
    span: Span


class Called(Node):
    """`150 g called "empty"`: a level of a factor with its label."""

    value: Expr
    text: Text
    span: Span


Expr = Called | Number | Text | Truth | Name | Member | Index | Call | Operation | Range | Items | WhatIf | Cause

# ---------------------------------------------------------------- statements


class Docstring(Node):
    """Three-quoted text."""

    text: str
    span: Span


class Use(Node):
    """`use room(style: warm) as here only [floor, front]`; `only` is the list as written."""

    name: Name
    given: tuple[Property, ...]
    prefix: Name | None
    only: Expr | None
    span: Span


class Word(Node):
    """A word of the language, which refers to no declaration."""

    id: str
    span: Span


class Factor(Node):
    """`factor name in domain about color`, or the same with `nuisance`; `about` is optional.

    `count` is set for `nuisance name[count] in domain`.
    """

    name: Name
    domain: Expr
    nuisance: bool
    span: Span
    about: Word | None = None
    count: Expr | None = None


class Let(Node):
    """`let name = value`."""

    name: Name
    value: Expr
    span: Span


class Parameter(Node):
    """`parameter style = warm`: a value that users of a library may override.

    A parameter `in` a list (`domain`) takes one of its items, by default the first.
    """

    name: Name
    value: Expr
    span: Span
    domain: Expr | None = None


class Require(Node):
    """`require condition`."""

    condition: Expr
    span: Span


class Holdout(Node):
    """`holdout factor in levels`, `holdout (factor, factor) in [(level, level)]`."""

    target: Expr
    levels: Expr
    span: Span


class Setting(Node):
    """`title "..."`, `repeat 4`, `horizon 2 s`: one value of the task itself."""

    key: str
    value: Expr
    span: Span


class Property(Node):
    """`mass: 200 g`; `at` is the second half of `on: table at (x, y)`."""

    name: Name
    value: Expr
    at: Expr | None
    span: Span


class Part(Node):
    """`part name { properties }`: one piece of a compound object."""

    name: Name
    properties: tuple[Property, ...]
    span: Span


class Block(Node):
    """`object name : model { properties parts }`, and the same for cameras, lights, joints, robots and the world.

    The world has no name. `count` is set for `objects name[count] { ... }` and `joints name[count] : model { ... }`.
    `whole` is never written: it names the object of an asset that a link or joint belongs to.
    """

    kind: str
    name: Name
    properties: tuple[Property, ...]
    span: Span
    model: Name | None = None
    count: Expr | None = None
    parts: tuple[Part, ...] = ()
    whole: str = ""


class Template(Node):
    """`template name(parameter: default) { properties parts }`: the common part of objects of this model."""

    name: Name
    parameters: tuple[Property, ...]
    properties: tuple[Property, ...]
    parts: tuple[Part, ...]
    span: Span


class Design(Node):
    """`design sample of 500`, `design one_at_a_time { speed: 0.9 m/s }`: which combinations of factors occur."""

    kind: Name
    count: Expr | None
    baseline: tuple[Property, ...]
    span: Span


class Tolerance(Node):
    """`tolerance position 5 mm`: allowed disagreement between engines."""

    name: Name
    value: Expr
    span: Span


class Timing(Node):
    """`at 0.2 s`, `for 2 s`, `after push`, `with push`, `when kind == "moved"`."""

    kind: str
    value: Expr
    span: Span


class Action(Node):
    """`action name = verb(arguments) timings`; `count` is set for `actions name[count] = verb(arguments) timings`."""

    name: Name
    call: Expr
    timings: tuple[Timing, ...]
    span: Span
    count: Expr | None = None


class Observe(Node):
    """`observe camera at times as channels`."""

    camera: Name
    times: Expr
    span: Span
    channels: Expr | None = None


class Film(Node):
    """`film camera from time to time`; without times, from the start to the last picture."""

    camera: Name
    start: Expr | None
    end: Expr | None
    span: Span


class Change(Node):
    """The one change of a counterfactual or what-if.

    `kind` is action, state, level (of a factor), without, order, or add (an action with its `timings`).
    """

    kind: str
    target: Expr
    value: Expr | None
    span: Span
    timings: tuple[Timing, ...] = ()


class Counterfactual(Node):
    """`counterfactual name { change }`."""

    name: Name
    changes: tuple[Change, ...]
    span: Span


class EachOther(Node):
    """`counterfactual each other level`: one counterfactual for every other value of the target."""

    target: Expr
    span: Span


class Kinds(Node):
    """`kinds { tips: toppled(bar) stands: true }`: the kinds of outcome of a question; the first true one applies."""

    kinds: tuple[Property, ...]
    span: Span


class Clause(Node):
    """A clause of a question: its keyword and value; `margin value apart by bound unless exception` has all three.

    `may hide value` is of the kind `hide`; `seen value at times` has the times as `bound`.
    """

    kind: str
    value: Expr
    bound: Expr | None
    span: Span
    unless: Expr | None = None


class Legibility(Node):
    """`legibility off`: whether the question must be legible."""

    word: Word
    span: Span


class ModelText(Node):
    """`film_text "text"`, `action_text "text"`: a text for models that continue the film; `kind` is the keyword."""

    kind: str
    text: Pieces
    span: Span


class Question(Node):
    """`question name "text" { clauses }`; the name may be left out."""

    text: Pieces
    clauses: tuple[Clause, ...]
    counterfactuals: tuple[Counterfactual | EachOther, ...]
    span: Span
    name: Name | None = None
    kinds: tuple[Kinds, ...] = ()
    legibility: tuple[Legibility, ...] = ()
    model_texts: tuple[ModelText, ...] = ()


Statement = (
    Docstring
    | Use
    | Factor
    | Let
    | Parameter
    | Require
    | Holdout
    | Setting
    | Design
    | Tolerance
    | Template
    | Block
    | Action
    | Observe
    | Film
    | Question
)


class Variant(Node):
    """`variant room { statements }`: a task of its own that includes the common statements of all variants."""

    name: Name
    body: tuple[Statement, ...]
    span: Span


class Task(Node):
    """`task name : dimension.path { statements }`."""

    name: Name
    path: tuple[Name, ...]
    body: tuple[Statement | Variant, ...]
    span: Span


class File(Node):
    """A whole file: a task file holds one or more tasks, a library none."""

    items: tuple[Statement | Task, ...]
    span: Span
    whole: bool = True
    """Whether recovery dropped nothing; if not, names may be missing."""


def statements(items: Iterable[Statement | Variant | Task]) -> Iterator[Statement]:
    """Yield the statements of a file, of its tasks and of their variants."""
    for item in items:
        if isinstance(item, Task | Variant):
            yield from statements(item.body)
        else:
            yield item


def nodes(node: object, sort: type[N]) -> Iterator[N]:
    """Yield all nodes of a type in a subtree, in order."""
    stack = [node]
    while stack:
        one = stack.pop()
        if isinstance(one, sort):
            yield one
        parts = one if isinstance(one, tuple) else vars(one).values() if isinstance(one, Node) else ()
        stack += [part for part in parts if isinstance(part, COMPOSITE_TYPES)][::-1]
