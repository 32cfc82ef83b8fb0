"""The typed representation of a checked spec: names resolved, units gone (everything is SI), JSON both ways."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from wmspec.parse.source import Span


class Node(BaseModel):
    """Base of all parts: immutable, compared by value, closed."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class Place(Node):
    """Where something stands in the text: file, line and column from 1, and character offsets."""

    file: str
    line: int
    column: int
    start: int
    end: int

    @classmethod
    def of(cls, span: Span) -> Place:
        """A span as the IR keeps it."""
        return cls(file=span.source.name, line=span.line, column=span.column, start=span.start, end=span.end)

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


# ---------------------------------------------------------------- expressions


class Value(Node):
    """A constant: an SI number, a truth value, a text, a word, or the name of an object, camera or action."""

    kind: Literal["value"] = "value"
    value: bool | float | str


class Ref(Node):
    """The value of a factor, nuisance or `let`."""

    kind: Literal["ref"] = "ref"
    name: str


class Property(Node):
    """A property of an object, camera or light, or an argument of an action: `ball.mass`, `push.speed`."""

    kind: Literal["property"] = "property"
    owner: Expr
    name: str


class Operation(Node):
    """An operator applied to operands: `+ - * / == != < <= > >= and or not if`."""

    kind: Literal["operation"] = "operation"
    operator: str
    operands: tuple[Expr, ...]


class Call(Node):
    """A function of `vocabulary.FUNCTIONS` applied to arguments."""

    kind: Literal["call"] = "call"
    function: str
    arguments: tuple[Expr, ...]


class Items(Node):
    """A list or a tuple."""

    kind: Literal["items"] = "items"
    items: tuple[Expr, ...]


Expr = Annotated[Value | Ref | Property | Operation | Call | Items, Field(discriminator="kind")]

# ---------------------------------------------------------------- parts of a task


class Choices(Node):
    """A domain of finitely many constants."""

    kind: Literal["choices"] = "choices"
    values: tuple[bool | float | str, ...]


class Interval(Node):
    """A continuous domain, drawn from uniformly (SI)."""

    kind: Literal["interval"] = "interval"
    low: float
    high: float


Domain = Annotated[Choices | Interval, Field(discriminator="kind")]


class Factor(Node):
    """A factor or nuisance. `unit` is the SI unit of its values, `""` for words and plain numbers."""

    name: str
    domain: Domain
    nuisance: bool
    unit: str
    place: Place


class Let(Node):
    """A named value."""

    name: str
    value: Expr
    place: Place


class Require(Node):
    """A condition on factors that a combination must meet. `text` is how it was written."""

    condition: Expr
    text: str
    place: Place


class Setting(Node):
    """The value of one property or argument."""

    value: Expr
    place: Place


class Thing(Node):
    """An object, camera, light, the world, or an action (then `verb` is set): an owner of properties."""

    kind: Literal["object", "camera", "light", "world", "action"]
    name: str
    verb: str = ""
    properties: dict[str, Setting]
    place: Place


class Observation(Node):
    """A camera's pictures: `times` is a list of times."""

    camera: str
    times: Expr
    place: Place


class Counterfactual(Node):
    """What if one thing were different: `owner.property` becomes `value`, of kind `sort`; or the action is left out.

    A left out action has no `property`, `value` or `sort`.
    """

    name: str
    change: Literal["action", "state", "without"]
    owner: str
    property: str
    value: Expr | None
    sort: str
    place: Place


class Margin(Node):
    """`value` must be at least `bound` away: from 0, or, for a ratio (a plain number), from 1 by that factor."""

    value: Expr
    bound: Expr
    ratio: bool
    place: Place


class Said(Node):
    """A value spoken within a text; `sort` is its kind (`color`, `object`, `length`, ...), which decides how."""

    value: Expr
    sort: str


class Question(Node):
    """A question. `text` alternates literal texts and values spoken. `sort` is the kind of the options.

    With `options` the answer is one of them; without, the answer is a picture and the other options are the
    pictures of the counterfactuals.
    """

    text: tuple[str | Said, ...]
    sort: str
    options: Expr | None
    answer: Expr
    margins: tuple[Margin, ...]
    ensures: tuple[Require, ...]
    distinct: Expr | None
    counterfactuals: tuple[Counterfactual, ...]
    place: Place


class TaskSpec(Node):
    """A whole task, ready to be designed, staged, executed and asked."""

    format: Literal[1] = 1
    name: str
    dimension: str
    title: str
    description: str
    license: str
    source: str
    factors: tuple[Factor, ...]
    lets: tuple[Let, ...]
    requires: tuple[Require, ...]
    repeat: int
    things: tuple[Thing, ...]
    horizon: Expr
    observations: tuple[Observation, ...]
    questions: tuple[Question, ...]

    def thing(self, name: str) -> Thing:
        """The object, camera, light, action or world of that name."""
        return next(t for t in self.things if t.name == name)


def task_schema() -> dict[str, Any]:
    """The JSON schema (draft 2020-12) of a `TaskSpec` as JSON."""
    schema = TaskSpec.model_json_schema(mode="serialization")
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
