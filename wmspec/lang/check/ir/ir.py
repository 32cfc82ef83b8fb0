"""Typed representation of a checked spec: names resolved, all quantities in SI units.

Immutable dataclasses, compared by value. `wmspec.lang.check.ir.record` converts them to and from JSON.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import field
from typing import Annotated, Any, Literal, dataclass_transform

from wmspec.core import node
from wmspec.core.places import Location


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(field,))
class Node(node.Node):
    """Base class."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__(kw_only=True)


class ByKind:
    """Pydantic annotation of a union discriminated by `kind`. The checker works without pydantic."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Callable[[Any], Any]) -> Any:
        """Return the schema of the union `source`."""
        from pydantic import Field

        return handler(Annotated[source, Field(discriminator="kind")])


# ---------------------------------------------------------------- expressions


class Value(Node):
    """A constant: an SI number, a truth value, a text, a word, or the name of an entity."""

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
    """An operator with operands: `+ - * / == != < <= > >= and or not if`, and `x y z` of a point.

    `each` is the index of a list operand: the operator is applied to each of its items, and the value is a list.
    """

    kind: Literal["operation"] = "operation"
    operator: str
    operands: tuple[Expr, ...]
    each: int | None = None


class Option(Node):
    """A named option of a function call."""

    name: str
    value: Expr


class Call(Node):
    """A call of a function of `functions.FUNCTIONS`. `each` is that of an operation.

    Four functions have no table row: `present` filters entities by presence, `nth` returns the item of a list at an
    index, counted from the end if negative, `member` that of a set at an index that depends on factors, and
    `heading_of` the angle of a direction word.
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


class WhatIf(Node):
    """The value of an expression in the episode with one `change`."""

    kind: Literal["what_if"] = "what_if"
    value: Expr
    change: Counterfactual


class Cause(Node):
    """The one of the `candidates` (objects or actions) without which `condition` does not hold."""

    kind: Literal["cause"] = "cause"
    condition: Expr
    candidates: Expr
    place: Location


Expr = Annotated[Value | Ref | Property | Operation | Call | Items | WhatIf | Cause, ByKind()]

# ---------------------------------------------------------------- parts of a task


Scalar = bool | float | str
Level = Scalar | tuple[float, ...]


class Choices(Node):
    """A finite domain of constants (a tuple is a point), optionally with sampling `weights`.

    `when` are the conditions of a conditional domain, on other factors: value `i` is allowed where `when[i]` holds.
    `names` are the labels of the values, in order, if the spec has them.
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
    """A normal distribution (SI), truncated at three standard deviations."""

    kind: Literal["normal"] = "normal"
    mean: float
    deviation: float


Domain = Annotated[Choices | Interval | Normal, ByKind()]


class Factor(Node):
    """A factor or nuisance. `unit` is the SI unit of its values, `""` for words and plain numbers.

    `about` is its declared dimension, `""` if the spec declares none.
    """

    name: str
    domain: Domain
    nuisance: bool
    unit: str
    place: Location
    about: str = ""

    def called(self, value: Level) -> str | None:
        """Return the label of a value, or None if values have no labels."""
        if not isinstance(self.domain, Choices) or self.domain.names is None:
            return None
        return self.domain.names[self.domain.values.index(value)]


class Let(Node):
    """A named value."""

    name: str
    value: Expr
    place: Location


class Require(Node):
    """A condition on factors that every combination must meet. `text` is its source."""

    condition: Expr
    text: str
    place: Location


class Holdout(Node):
    """Combinations of levels that training never sees: each of `levels` has a level for every one of `factors`."""

    factors: tuple[str, ...]
    levels: tuple[tuple[Level, ...], ...]
    place: Location


class Setting(Node):
    """The value of one property or argument."""

    value: Expr
    place: Location


EntityKind = Literal["object", "part", "camera", "light", "joint", "robot", "world", "action"]


class Entity(Node):
    """An owner of properties: an object, camera, light, joint, robot, the world, an action, or a part of an object.

    `verb` is set for actions; an `added` action occurs only under the counterfactual that adds it. `model` is the kind
    of a joint (hinge, slider, ball, fixed) or the model of a robot.

    An action with a condition has the property `when`.

    A part is named `object.part` and `of` is its object. `of` of an action is the acting robot, if any. A member of a
    set is named `set_index` and has the set's name in `set`. Links and joints of an asset are objects and joints whose
    `of` is the asset's base. Their poses are relative to the asset's frame, with all joints at 0.
    """

    kind: EntityKind
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
    """The pictures of a camera: `times` is a list of times, `channels` are the recorded channels."""

    camera: str
    times: Expr
    channels: tuple[Channel, ...] = ("rgb",)
    place: Location


class Film(Node):
    """The film shown to video models: a camera, and first and last time (s).

    Without times it begins at 0 and ends with the last picture.
    """

    camera: str
    start: Expr | None = None
    end: Expr | None = None
    place: Location


def time_of_last_picture(observations: Iterable[Observation]) -> Call:
    """Return the time of the last picture, which ends a task without a `horizon`."""
    return Call(function="max", arguments=tuple(o.times for o in observations))


Change = Literal["action", "state", "without", "order", "add", "levels"]


#: The name of the option that shows the episode as it is, where the answer is a what-if.
ACTUAL = "actual"


class Counterfactual(Node):
    """One change of an instance: `owner.property` becomes `value` (of type `sort`), or `owner` is left out.

    A left-out object or action, and an added action, has no `property` or `sort`. Without an `owner`, `value` is the
    left-out one, which depends on factors. The change `order` swaps the start times of the
    actions `owner` and `property`. The change `levels` sets other levels of factors. Counterfactuals for each other
    level have `levels` too; an instance with these levels has no such counterfactual.
    """

    name: str
    change: Change
    owner: str
    property: str
    value: Expr | None
    sort: str
    levels: dict[str, Level] = field(default_factory=dict)
    place: Location


class OrbitFactor(Node):
    """A factor of an orbit, and what depends on it: the initial state, the action, or both."""

    factor: str
    reads: Literal["state", "action", "both"]


class Outcome(Node):
    """A kind of outcome: where `condition` holds. `text` is its source."""

    name: str
    condition: Expr
    text: str
    place: Location


class Margin(Node):
    """`value` must be at least `bound` away from 0 or, for a ratio, from 1 by this factor.

    The margin is not required where `unless` holds.
    """

    value: Expr
    bound: Expr
    ratio: bool
    unless: Expr | None = None
    place: Location


class Interpolation(Node):
    """A value inserted into a text; its type `sort` (`color`, `object`, `length`, …) determines the wording."""

    value: Expr
    sort: str


class TextTemplate(Node):
    """A text with inserted values among options and answers; `text` is the value that stands for it."""

    text: str
    parts: tuple[str | Interpolation, ...]


class Visibility(Node):
    """The pictures in which `objects` must be visible: those at `times` (s), or none if `times` is None.

    `objects` is an object or a list; None stands for every object of the question.
    """

    objects: Expr | None
    times: Expr | None
    place: Location


class Difference(Node):
    """Stimulus strength, such as the ratio of two speeds: recorded as a covariate of accuracy."""

    value: Expr
    unit: str


#: Options of a question: labels (in words), numbers (open answers), pictures, or whether the episode is possible.
QuestionKind = Literal["labels", "numbers", "pictures", "possible"]


class Question(Node):
    """A question. `text` alternates literal texts and inserted values. `sort` is the type of the answer.

    For labels, the answer is one of the `options`. An open number is right if it is `within` that tolerance. For
    pictures, the other options are the pictures of the counterfactuals. If these are the siblings in the instance's
    group, the question has an `orbit`: the set of options is closed, the same for every answer.

    Two pictures must differ by the length `distinct` (m) or the angle `distinct_turn` (rad) and, if `distinct_kinds`,
    by the kind of their outcome, the first of `kinds` that holds. `texts` are the options with inserted values.
    `stable` is the displacement (m) of every free object under which the answer must hold. Without `legible`,
    illegible instances are kept. Objects of the question must be visible in every picture, unless `visibility` says
    otherwise. `film_text` describes the film for video models, without the question. `action_text` describes the action
    for models that receive the last picture only.
    """

    name: str = ""
    text: tuple[str | Interpolation, ...]
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
    legible: bool = True
    visibility: tuple[Visibility, ...] = ()
    counterfactuals: tuple[Counterfactual, ...]
    orbit: tuple[OrbitFactor, ...] = ()
    kinds: tuple[Outcome, ...] = ()
    distinct_turn: Expr | None = None
    distinct_kinds: bool = False
    texts: tuple[TextTemplate, ...] = ()
    film_text: tuple[str | Interpolation, ...] = ()
    action_text: tuple[str | Interpolation, ...] = ()
    place: Location

    @property
    def has_closed_pictures(self) -> bool:
        """Whether the options are a closed set of pictures, each of which can have a film."""
        return bool(self.orbit) and self.kind == "pictures"

    @property
    def asks_possible(self) -> bool:
        """Whether the question is whether its episode is possible."""
        return self.kind == "possible"

    def alternatives(self, levels: Mapping[str, Level]) -> tuple[Counterfactual, ...]:
        """Return the counterfactuals of an instance with these levels, without those that equal the instance."""
        return tuple(
            change
            for change in self.counterfactuals
            if not change.levels or any(levels[name] != level for name, level in change.levels.items())
        )


PlanKind = Literal["factorial", "sample", "latin", "one_at_a_time", "groups"]


class Plan(Node):
    """The combinations of factors that make up the design.

    factorial: all. sample: `count` distinct ones, balanced. latin: a Latin hypercube of `count`. one_at_a_time: the
    `baseline` and all that differ from it in one factor. groups: `count` control groups; in each the factors `cross`
    are crossed, and one of `turn`, in rotation; all others are drawn again for each group. `balance` names the question
    whose measured answers must be equally frequent; groups are drawn until they are.
    """

    kind: PlanKind = "factorial"
    count: int | None = None
    baseline: dict[str, Level] = field(default_factory=dict)
    cross: tuple[str, ...] = ()
    turn: tuple[str, ...] = ()
    balance: str = ""
    place: Location | None = None


#: Separates the licences, and the sources, of a task and its libraries.
CREDIT_SEPARATOR = "; "


class TaskSpec(Node):
    """A complete checked task."""

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
    things: tuple[Entity, ...]
    horizon: Expr
    observations: tuple[Observation, ...]
    questions: tuple[Question, ...]
    film: Film | None = None
    holdouts: tuple[Holdout, ...] = ()

    def is_held_out(self, levels: Mapping[str, Level]) -> bool:
        """Whether an instance with these levels has a combination that training never sees."""
        return any(tuple(levels[name] for name in out.factors) in out.levels for out in self.holdouts)

    @property
    def licenses(self) -> tuple[str, ...]:
        """The licences of the task and its libraries."""
        return tuple(self.license.split(CREDIT_SEPARATOR)) if self.license else ()

    def factor(self, name: str) -> Factor:
        """Return the factor or nuisance of that name."""
        return next(f for f in self.factors if f.name == name)

    def thing(self, name: str) -> Entity:
        """Return the object, part, camera, light, joint, robot, action or world of that name."""
        return next(t for t in self.things if t.name == name)
