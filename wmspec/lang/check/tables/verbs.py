"""Tables of verbs: actions on objects and of robots."""

from __future__ import annotations

from dataclasses import dataclass

from wmspec.lang.check.tables.vocabulary import PropertySpec
from wmspec.lang.check.types.types import (
    A_LENGTH,
    AN_ANGLE,
    COLOR,
    DIRECTION,
    JOINT,
    OBJECT,
    PATH,
    PLACE,
    POINT2,
    POINT3,
    TRUTH,
    List,
    Quantity,
)
from wmspec.lang.check.types.units import FORCE, IMPULSE, SPEED


@dataclass(frozen=True)
class Verb:
    """A verb: its arguments in order. `start` and `duration` come from the timings `at`, `for`, ...

    `lasts`: it requires `for TIME`. `author` writes it to the stage, as `module:function`; a verb without one is
    checked, but cannot be staged. `staged` is the stage's action type if it differs from the name. `carries`: it moves
    its object regardless of obstacles. `holds`: its object is fixed until then. `allows_carried`: it also applies to
    carried objects. `violates`: it breaks the laws of physics, so an episode in which it has an effect is impossible.
    """

    meaning: str
    arguments: dict[str, PropertySpec]
    lasts: bool
    author: str = ""
    staged: str = ""
    carries: bool = False
    holds: bool = False
    allows_carried: bool = False
    violates: bool = False


_DIRECTION = PropertySpec(
    (AN_ANGLE, DIRECTION), "heading on the ground, anticlockwise from +x; a word; or `toward(object)`"
)
_OBJECT = PropertySpec((OBJECT,), "what is moved")

VERBS: dict[str, Verb] = {
    "launch": Verb(
        "gives the object a velocity, as a sudden push would",
        {
            "object": _OBJECT,
            "direction": _DIRECTION,
            "speed": PropertySpec((Quantity(SPEED),), "how fast it sets off", least=0, most=100),
            "climb": PropertySpec((AN_ANGLE,), "how steeply upwards", "0 deg"),
            "rolling": PropertySpec((TRUTH,), "whether a round object sets off rolling instead of sliding", "false"),
        },
        lasts=False, author="wmspec.compile.stage.actions:launch",
    ),
    "slide": Verb(
        "sets the object sliding on what it rests on, as fast as makes friction stop it after the distance",
        {"object": _OBJECT, "direction": _DIRECTION, "distance": PropertySpec((A_LENGTH,), "how far it slides", above=0)},
        lasts=False, author="wmspec.compile.stage.actions:slide", staged="launch",
    ),
    "glide": Verb(
        "carries the object along a straight line at constant speed, pushing whatever is in its way",
        {
            "object": _OBJECT,
            "direction": _DIRECTION,
            "speed": PropertySpec((Quantity(SPEED),), "how fast it goes", least=0, most=100),
        },
        lasts=True, author="wmspec.compile.stage.actions:glide", carries=True,
    ),
    "follow": Verb(
        "carries the object along a path at constant speed, from where it is",
        {
            "object": _OBJECT,
            "path": PropertySpec((PATH, List(POINT2), List(POINT3)), "the form of the path, or points relative to where it is"),
            "direction": PropertySpec((AN_ANGLE, DIRECTION), "where the path leads; turns given points too", "0 deg"),
            "length": PropertySpec((A_LENGTH,), "from one end of the path to the other; the diameter of a circle, the side of a square or triangle", "40 cm", above=0),
            "width": PropertySpec((A_LENGTH,), "how far the path strays to the side", "10 cm", above=0),
            "facing": PropertySpec((TRUTH,), "whether it turns with the path, as a car does; else it keeps its turn", "false"),
        },
        lasts=True, author="wmspec.compile.stage.actions:follow", carries=True,
    ),
    "teleport": Verb(
        "puts the object somewhere else at once; a moving object keeps its velocity",
        {
            "object": _OBJECT,
            "to": PropertySpec((POINT2, POINT3, PLACE), "where to, as in its `at`"),
            "yaw": PropertySpec((AN_ANGLE,), "how it is turned there; as before if left out", optional=True),
        },
        lasts=False, author="wmspec.compile.stage.actions:teleport", allows_carried=True, violates=True,
    ),
    "impulse": Verb(
        "strikes the object in its centre of mass",
        {
            "object": _OBJECT,
            "direction": _DIRECTION,
            "impulse": PropertySpec((Quantity(IMPULSE),), "mass times the change of velocity", least=0),
            "climb": PropertySpec((AN_ANGLE,), "how steeply upwards", "0 deg"),
        },
        lasts=False, author="wmspec.compile.stage.actions:impulse",
    ),
    "force": Verb(
        "pulls the object at its centre of mass",
        {
            "object": _OBJECT,
            "direction": _DIRECTION,
            "force": PropertySpec((Quantity(FORCE),), "how strongly", least=0),
            "climb": PropertySpec((AN_ANGLE,), "how steeply upwards", "0 deg"),
        },
        lasts=True, author="wmspec.compile.stage.actions:force",
    ),
    "release": Verb("holds the object where it is until then, and lets go", {"object": _OBJECT}, lasts=False, author="wmspec.compile.stage.actions:release", holds=True),
    "drop": Verb(
        "holds the object above where it would rest until then, and lets go",
        {"object": _OBJECT, "height": PropertySpec((A_LENGTH,), "how far above", above=0, most=100)},
        lasts=False, author="wmspec.compile.stage.actions:release", staged="release", holds=True,
    ),
    "drive": Verb(
        "sends a joint's drive to another target",
        {"joint": PropertySpec((JOINT,), "which joint"), "target": PropertySpec((AN_ANGLE, A_LENGTH), "where to")},
        lasts=False, author="wmspec.compile.stage.actions:drive",
    ),
    "stop": Verb("makes the object stand still at once", {"object": _OBJECT}, lasts=False, author="wmspec.compile.stage.actions:stop", staged="launch", violates=True),
    "paint": Verb(
        "gives all of the object another colour",
        {"object": PropertySpec((OBJECT,), "what is painted"), "color": PropertySpec((COLOR,), "which colour")},
        lasts=False, author="wmspec.compile.stage.actions:paint", allows_carried=True, violates=True,
    ),
    "vanish": Verb(
        "takes the object away: from then on nothing touches or shows it",
        {"object": PropertySpec((OBJECT,), "what vanishes")},
        lasts=False, author="wmspec.compile.stage.actions:vanish", allows_carried=True, violates=True,
    ),
    "pass_through": Verb(
        "lets the object go through another one, as if that were not solid",
        {
            "object": PropertySpec((OBJECT,), "what goes through"),
            "through": PropertySpec((OBJECT,), "what it goes through"),
        },
        lasts=True, author="wmspec.compile.stage.actions:pass_through", allows_carried=True, violates=True,
    ),
}  # fmt: skip

_GRIPPED = PropertySpec((OBJECT,), "what is handled")
_FAR = PropertySpec((A_LENGTH,), "how far", above=0, most=100)
_HIGH = PropertySpec((A_LENGTH,), "how high", above=0, most=2)
_SIDE = PropertySpec((DIRECTION,), "to which side, as the robot sees it: `left` or `right`", among=("left", "right"))
_WHERE = PropertySpec(
    (POINT2,), "where it takes it, along its own axes, from its middle: beside it, it misses", "(0 m, 0 m)"
)
_HANDLE = PropertySpec((OBJECT,), "what it takes")
_JOINT = PropertySpec((JOINT,), "a hinge or slider")
_ALONG = PropertySpec((AN_ANGLE, A_LENGTH), "how far, in the joint's own sense", above=0, most=6.3)
_BY = PropertySpec((AN_ANGLE,), "by how much", "90 deg", above=0, most=6.3)

#: Verbs of arms.
_ARM = {
    "push": Verb("pushes an object over what it rests on", {"object": _GRIPPED, "direction": _DIRECTION, "distance": _FAR}, True),
    "pick": Verb("grasps an object and lifts it", {"object": _GRIPPED, "height": _HIGH, "at": _WHERE}, True),
    "grasp": Verb("grasps an object where it is, on something or in another hand", {"object": _GRIPPED, "at": _WHERE}, True),
    "lift": Verb("raises an object that it holds, or an end of it", {"object": _GRIPPED, "height": _HIGH, "at": PropertySpec((POINT2,), "where it takes it, along its own axes, from its end: beside it, it misses", "(0 m, 0 m)")}, True),
    "carry": Verb("moves an object that it holds to a side", {"object": _GRIPPED, "direction": _DIRECTION, "distance": _FAR}, True),
    "place": Verb("puts down the object that it holds", {"object": _GRIPPED, "on": PropertySpec((OBJECT,), "on what"), "at": PropertySpec((POINT2,), "where on it", "(0 m, 0 m)")}, True),
    "rotate": Verb("turns an object that it holds", {"object": _GRIPPED, "angle": PropertySpec((AN_ANGLE,), "by how much, anticlockwise from above")}, True),
    "tilt": Verb("tips an object that it holds, as one pours", {"object": _GRIPPED, "angle": PropertySpec((AN_ANGLE,), "how far"), "direction": PropertySpec((AN_ANGLE, DIRECTION), "to which side its top goes", "0 deg")}, True),
    "drop": Verb("opens its hand", {"object": _GRIPPED}, False),
    "open": Verb("takes a handle, moves it as a joint lets it, and lets go", {"object": _HANDLE, "joint": _JOINT, "far": _ALONG, "at": _WHERE}, True),
    "close": Verb("does so the other way", {"object": _HANDLE, "joint": _JOINT, "far": _ALONG, "at": _WHERE}, True),
}  # fmt: skip

#: Verbs of each robot model. They take the time given by `for TIME`.
ROBOTS: dict[str, dict[str, Verb]] = {
    "panda": _ARM,
    "arm": _ARM,
    "car": {
        "forward": Verb("drives on along its lane", {"distance": _FAR}, True),
        "turn": Verb("drives on to the next crossing, turns into the road on that side, and a little further", {"direction": _SIDE}, True),
        "change_lane": Verb("moves over to the next lane", {"direction": _SIDE}, True),
        "stop": Verb("brakes to a halt in its lane", {}, True),
        "go_to": Verb("drives the shortest way to where one of its roads is nearest to an object", {"to": PropertySpec((OBJECT,), "where to")}, True),
    },
    "walker": {
        "move": Verb("walks straight ahead, until something stops it", {"distance": _FAR}, True),
        "back": Verb("walks straight back, until something stops it", {"distance": _FAR}, True),
        "go_to": Verb("walks the shortest way around all that stands there to within reach of an object, and turns to it", {"to": PropertySpec((OBJECT,), "where to")}, True),
        "turn": Verb("turns on the spot", {"direction": _SIDE, "angle": _BY}, True),
        "look": Verb("looks up or down", {"angle": PropertySpec((AN_ANGLE,), "how far up from level; negative is down", least=-1.5, most=1.5)}, True),
    },
}  # fmt: skip

#: Verbs of other languages and their names here.
VERB_ALIASES: dict[str, str] = {
    **dict.fromkeys(("throw", "toss", "shoot", "kick", "roll", "set_velocity"), "launch"),
    **dict.fromkeys(("hit", "strike", "knock"), "impulse"),
    **dict.fromkeys(("animate", "translate", "walk"), "glide"),
    **dict.fromkeys(("set_position", "place_at", "jump"), "teleport"),
    **dict.fromkeys(("remove", "hide", "disappear", "delete"), "vanish"),
    **dict.fromkeys(("recolor", "colour", "color"), "paint"),
    **dict.fromkeys(("fall",), "drop"),
    **dict.fromkeys(("freeze", "halt"), "stop"),
}
#: Verbs of objects that correspond to verbs of robots.
OBJECT_VERBS: dict[str, str] = {"push": "launch", "move": "glide", "carry": "glide", "rotate": "follow"}
