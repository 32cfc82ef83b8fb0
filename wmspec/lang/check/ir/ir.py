"""The typed representation of a checked spec: names resolved, units gone (everything is SI).

Dataclasses that nothing changes, compared by value. `wmspec.lang.check.ir.record` writes them as JSON and reads them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import field
from typing import Annotated, Any, Literal, dataclass_transform

from wmspec.core import node
from wmspec.core.places import Location


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(field,))
class Node(node.Node):
    """Base of all parts."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__(kw_only=True)


class ByKind:
    """Tells pydantic that the `kind` says which of several parts one is. The checker does without pydantic."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Callable[[Any], Any]) -> Any:
        """The schema of the union `source`."""
        from pydantic import Field

        return handler(Annotated[source, Field(discriminator="kind")])


# ---------------------------------------------------------------- expressions


class Value(Node):
    """A constant: an SI number, a truth value, a text, a word, or the name of a thing."""

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
    """An operator applied to operands: `+ - * / == != < <= > >= and or not if`, and `x y z` of a point.

    With `each`, the operand of that number is a list, and it is applied to every item of that: the value is a list.
    """

    kind: Literal["operation"] = "operation"
    operator: str
    operands: tuple[Expr, ...]
    each: int | None = None


class Option(Node):
    """An option of a function that is given, by its name."""

    name: str
    value: Expr


class Call(Node):
    """A function of `functions.FUNCTIONS` applied to arguments. `each` is as of an operation.

    Two functions have no row there: `present`, of things those that are there, and `nth`, of a list the item with a
    number, counted from the end if it is below 0.
    """

    kind: Literal["call"] = "call"
    function: str
    arguments: tuple[Expr, ...]
    options: tuple[Option, ...] = ()
    each: int | None = None


class Items(Node):
    """A list or a tuple."""

    kind: Literal["items"] = "items"
    items: tuple[Expr, ...]


Expr = Annotated[Value | Ref | Property | Operation | Call | Items, ByKind()]

# ---------------------------------------------------------------- parts of a task


Scalar = bool | float | str
Level = Scalar | tuple[float, ...]


class Choices(Node):
    """A domain of finitely many constants (a tuple is a point). With `weights` some are drawn more often than others.

    `when` are the conditions of a conditional domain, on other factors: value `i` is allowed where `when[i]` holds.
    `names` are what the values are called, in their order, if the spec says so.
    """

    kind: Literal["choices"] = "choices"
    values: tuple[Level, ...]
    weights: tuple[float, ...] | None = None
    when: tuple[Expr, ...] | None = None
    names: tuple[str, ...] | None = None


class Interval(Node):
    """A continuous domain (SI): uniform, or uniform in the logarithm."""

    kind: Literal["interval"] = "interval"
    low: float
    high: float
    logarithmic: bool = False


class Normal(Node):
    """A normal distribution (SI), cut off at three deviations from its mean so that no draw is absurd."""

    kind: Literal["normal"] = "normal"
    mean: float
    deviation: float


Domain = Annotated[Choices | Interval | Normal, ByKind()]


class Factor(Node):
    """A factor or nuisance. `unit` is the SI unit of its values, `""` for words and plain numbers."""

    name: str
    domain: Domain
    nuisance: bool
    unit: str
    place: Location

    def called(self, value: Level) -> str | None:
        """The name of one of its values; None if values have no names."""
        if not isinstance(self.domain, Choices) or self.domain.names is None:
            return None
        return self.domain.names[self.domain.values.index(value)]


class Let(Node):
    """A named value."""

    name: str
    value: Expr
    place: Location


class Require(Node):
    """A condition on factors that a combination must meet. `text` is how it was written."""

    condition: Expr
    text: str
    place: Location


class Setting(Node):
    """The value of one property or argument."""

    value: Expr
    place: Location


ThingKind = Literal["object", "part", "camera", "light", "joint", "robot", "world", "action"]


class Thing(Node):
    """An owner of properties: an object, camera, light, joint, robot, the world, an action, or a part of an object.

    `verb` is that of an action; one that is `added` happens only under the counterfactual that adds it. `model` is the
    kind of a joint (hinge, slider, ball, fixed) or the model of a robot. A part is named `object.part` and `of` is its
    object; `of` of an action is the robot that acts, if any. A member of a set has the set's name in `set` and is named
    `set_index`. The links and joints of an asset are objects and joints whose `of` is the object that is its base;
    where they are is counted from the frame in which that is placed, when all joints are at 0.
    """

    kind: ThingKind
    name: str
    verb: str = ""
    model: str = ""
    of: str = ""
    set: str = ""
    added: bool = False
    properties: dict[str, Setting]
    place: Location


Channel = Literal["rgb", "depth", "ids"]


class Observation(Node):
    """A camera's pictures: `times` is a list of times. `channels` are what is kept of each picture."""

    camera: str
    times: Expr
    channels: tuple[Channel, ...] = ("rgb",)
    place: Location


def last_shown(observations: Iterable[Observation]) -> Call:
    """When the last picture is taken: the end of a task that has no `horizon`."""
    return Call(function="max", arguments=tuple(o.times for o in observations))


Change = Literal["action", "state", "without", "order", "add", "levels"]


class Counterfactual(Node):
    """What if one thing were different: `owner.property` becomes `value`, of kind `sort`; or an action is left out.

    A left out or added action has no `property`, `value` or `sort`. A change of `order` swaps the turns of the actions
    `owner` and `property`. One of `levels` gives factors other levels. What stands for each other level of something
    has `levels` too: an instance that has these levels has no such counterfactual.
    """

    name: str
    change: Change
    owner: str
    property: str
    value: Expr | None
    sort: str
    levels: dict[str, Level] = field(default_factory=dict)
    place: Location


class Varied(Node):
    """A factor of an orbit, and what reads it: the state before anything happens, the action, or both."""

    factor: str
    reads: Literal["state", "action", "both"]


class Outcome(Node):
    """A kind of outcome: where `condition` holds. `text` is how it was written."""

    name: str
    condition: Expr
    text: str
    place: Location


class Margin(Node):
    """`value` must be at least `bound` away: from 0, or, for a ratio (a plain number), from 1 by that factor.

    Where `unless` holds it need not be.
    """

    value: Expr
    bound: Expr
    ratio: bool
    unless: Expr | None = None
    place: Location


class Said(Node):
    """A value spoken within a text; `sort` is its kind (`color`, `object`, `length`, ...), which decides how."""

    value: Expr
    sort: str


class Filled(Node):
    """A text among options and answers with values spoken within it; `text` is the value that stands for it."""

    text: str
    parts: tuple[str | Said, ...]


class Difference(Node):
    """How strong the stimulus is, such as the ratio of two speeds: recorded, since accuracy is analysed against it."""

    value: Expr
    unit: str


#: What a question has as options: labels, which are said in words; none, as an open number; pictures.
QuestionKind = Literal["labels", "numbers", "pictures"]


class Question(Node):
    """A question. `text` alternates literal texts and values spoken. `sort` is that of the answer's value.

    Of labels, the answer is one of the `options`. An open number is right `within` so much of it. Where the answer is a
    picture, the other options are the pictures of the counterfactuals. Where these are the siblings in the instance's
    group, the question has an `orbit`: the set of options is closed, the same whichever of them is true.
    Two pictures are `distinct` by so much (m), or by such a turn (`distinct_turn`, rad), and, if `distinct_kinds`, by
    the kind of their outcome: of `kinds`, the first that holds.
    `texts` are those of the options that say values.
    `stable` is how far (m) every free object is nudged to see whether the answer holds.
    """

    name: str = ""
    text: tuple[str | Said, ...]
    kind: QuestionKind
    sort: str
    options: Expr | None
    answer: Expr
    margins: tuple[Margin, ...]
    ensures: tuple[Require, ...]
    distinct: Expr | None
    within: Expr | None = None
    difference: Difference | None = None
    stable: Expr | None = None
    counterfactuals: tuple[Counterfactual, ...]
    orbit: tuple[Varied, ...] = ()
    kinds: tuple[Outcome, ...] = ()
    distinct_turn: Expr | None = None
    distinct_kinds: bool = False
    texts: tuple[Filled, ...] = ()
    place: Location

    def alternatives(self, levels: Mapping[str, Level]) -> tuple[Counterfactual, ...]:
        """The counterfactuals of an instance with these levels: those that are not what it is anyway."""
        return tuple(
            change
            for change in self.counterfactuals
            if not change.levels or any(levels[name] != level for name, level in change.levels.items())
        )


PlanKind = Literal["factorial", "sample", "latin", "one_at_a_time", "groups"]


class Plan(Node):
    """Which combinations of the factors make up the design.

    factorial: all of them. sample: `count` different ones, balanced. latin: a Latin hypercube of `count`.
    one_at_a_time: the `baseline` and what differs from it in one factor. groups: `count` control groups; in each the
    factors `cross` are crossed, and one of `turn`, which take turns; all else is drawn anew for each group. `balance`
    names the question whose measured answers are to come equally often; groups are drawn until they do.
    """

    kind: PlanKind = "factorial"
    count: int | None = None
    baseline: dict[str, Level] = field(default_factory=dict)
    cross: tuple[str, ...] = ()
    turn: tuple[str, ...] = ()
    balance: str = ""
    place: Location | None = None


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
    plan: Plan = field(default_factory=Plan)
    tolerances: dict[str, float] = field(default_factory=dict)
    things: tuple[Thing, ...]
    horizon: Expr
    observations: tuple[Observation, ...]
    questions: tuple[Question, ...]

    def factor(self, name: str) -> Factor:
        """The factor or nuisance of that name."""
        return next(f for f in self.factors if f.name == name)

    def thing(self, name: str) -> Thing:
        """The object, part, camera, light, joint, robot, action or world of that name."""
        return next(t for t in self.things if t.name == name)
