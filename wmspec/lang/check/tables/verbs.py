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
    (AN_ANGLE, DIRECTION),
    "horizontal heading: an angle anticlockwise from +x, a word such as `left`, or `toward(object)`",
)
_OBJECT = PropertySpec((OBJECT,), "the object")

VERBS: dict[str, Verb] = {
    "launch": Verb(
        "gives the object a velocity at once, as a sudden push does",
        {
            "object": _OBJECT,
            "direction": _DIRECTION,
            "speed": PropertySpec((Quantity(SPEED),), "initial speed", least=0, most=100),
            "climb": PropertySpec((AN_ANGLE,), "angle above the horizontal", "0 deg"),
            "rolling": PropertySpec((TRUTH,), "whether a round object rolls from the start instead of sliding", "false"),
        },
        lasts=False, author="wmspec.compile.stage.actions:launch",
    ),
    "slide": Verb(
        "launches the object so that it slides on its support until friction stops it after the distance",
        {"object": _OBJECT, "direction": _DIRECTION, "distance": PropertySpec((A_LENGTH,), "distance that the object slides", above=0)},
        lasts=False, author="wmspec.compile.stage.actions:slide", staged="launch",
    ),
    "glide": Verb(
        "moves the object along a straight line at constant speed; it pushes objects in its way",
        {
            "object": _OBJECT,
            "direction": _DIRECTION,
            "speed": PropertySpec((Quantity(SPEED),), "constant speed", least=0, most=100),
        },
        lasts=True, author="wmspec.compile.stage.actions:glide", carries=True,
    ),
    "follow": Verb(
        "moves the object along a path at constant speed, from its present place",
        {
            "object": _OBJECT,
            "path": PropertySpec((PATH, List(POINT2), List(POINT3)), "shape of the path, or points relative to the object's place at the start of the action"),
            "direction": PropertySpec((AN_ANGLE, DIRECTION), "direction of the path; given points are rotated by it too", "0 deg"),
            "length": PropertySpec((A_LENGTH,), "distance between the ends of the path; diameter of a circle, side of a square or triangle", "40 cm", above=0),
            "width": PropertySpec((A_LENGTH,), "sideways extent of the path", "10 cm", above=0),
            "facing": PropertySpec((TRUTH,), "whether the object turns with the path, as a car does; if not, it keeps its orientation", "false"),
        },
        lasts=True, author="wmspec.compile.stage.actions:follow", carries=True,
    ),
    "teleport": Verb(
        "places the object elsewhere at once; a moving object keeps its velocity",
        {
            "object": _OBJECT,
            "to": PropertySpec((POINT2, POINT3, PLACE), "new place, written like the property `at`"),
            "yaw": PropertySpec((AN_ANGLE,), "new yaw; default: unchanged", optional=True),
        },
        lasts=False, author="wmspec.compile.stage.actions:teleport", allows_carried=True, violates=True,
    ),
    "impulse": Verb(
        "applies an impulse at the object's centre of mass",
        {
            "object": _OBJECT,
            "direction": _DIRECTION,
            "impulse": PropertySpec((Quantity(IMPULSE),), "magnitude of the impulse: mass times change of velocity", least=0),
            "climb": PropertySpec((AN_ANGLE,), "angle above the horizontal", "0 deg"),
        },
        lasts=False, author="wmspec.compile.stage.actions:impulse",
    ),
    "force": Verb(
        "applies a force at the object's centre of mass",
        {
            "object": _OBJECT,
            "direction": _DIRECTION,
            "force": PropertySpec((Quantity(FORCE),), "magnitude of the force", least=0),
            "climb": PropertySpec((AN_ANGLE,), "angle above the horizontal", "0 deg"),
        },
        lasts=True, author="wmspec.compile.stage.actions:force",
    ),
    "release": Verb("holds the object in its place until the action begins, then releases it", {"object": _OBJECT}, lasts=False, author="wmspec.compile.stage.actions:release", holds=True),
    "drop": Verb(
        "holds the object above its resting place until the action begins, then releases it",
        {"object": _OBJECT, "height": PropertySpec((A_LENGTH,), "height above the resting place", above=0, most=100)},
        lasts=False, author="wmspec.compile.stage.actions:release", staged="release", holds=True,
    ),
    "drive": Verb(
        "sets the target of a joint's drive",
        {"joint": PropertySpec((JOINT,), "the joint"), "target": PropertySpec((AN_ANGLE, A_LENGTH), "target of the drive")},
        lasts=False, author="wmspec.compile.stage.actions:drive",
    ),
    "stop": Verb("stops the object at once", {"object": _OBJECT}, lasts=False, author="wmspec.compile.stage.actions:stop", staged="launch", violates=True),
    "paint": Verb(
        "changes the colour of the whole object",
        {"object": PropertySpec((OBJECT,), "the object"), "color": PropertySpec((COLOR,), "new colour")},
        lasts=False, author="wmspec.compile.stage.actions:paint", allows_carried=True, violates=True,
    ),
    "vanish": Verb(
        "removes the object: nothing touches or shows it from then on",
        {"object": PropertySpec((OBJECT,), "the object")},
        lasts=False, author="wmspec.compile.stage.actions:vanish", allows_carried=True, violates=True,
    ),
    "pass_through": Verb(
        "lets the object pass through another one without collision",
        {
            "object": PropertySpec((OBJECT,), "the object"),
            "through": PropertySpec((OBJECT,), "the object through which it passes"),
        },
        lasts=True, author="wmspec.compile.stage.actions:pass_through", allows_carried=True, violates=True,
    ),
}  # fmt: skip

_GRIPPED = PropertySpec((OBJECT,), "the object")
_FAR = PropertySpec((A_LENGTH,), "how far", above=0, most=100)
_HIGH = PropertySpec((A_LENGTH,), "height to which it is raised", above=0, most=2)
_SIDE = PropertySpec((DIRECTION,), "to which side, as the robot sees it: `left` or `right`", among=("left", "right"))
_WHERE = PropertySpec(
    (POINT2,),
    "grasp point in the object's own axes, relative to its middle; the grasp misses if this point is beside the object",
    "(0 m, 0 m)",
)
_HANDLE = PropertySpec((OBJECT,), "the handle")
_JOINT = PropertySpec((JOINT,), "a hinge or slider")
_ALONG = PropertySpec((AN_ANGLE, A_LENGTH), "angle or distance by which the joint moves", above=0, most=6.3)
_BY = PropertySpec((AN_ANGLE,), "angle of the turn", "90 deg", above=0, most=6.3)

#: Verbs of arms.
_ARM = {
    "push": Verb("pushes an object along its support", {"object": _GRIPPED, "direction": _DIRECTION, "distance": _FAR}, True),
    "pick": Verb("grasps an object and lifts it", {"object": _GRIPPED, "height": _HIGH, "at": _WHERE}, True),
    "grasp": Verb("grasps an object without moving it; the object may be on a support or in another hand", {"object": _GRIPPED, "at": _WHERE}, True),
    "lift": Verb("raises a held object, or one end of an object that is not held", {"object": _GRIPPED, "height": _HIGH, "at": PropertySpec((POINT2,), "grasp point of an empty hand in the object's own axes, relative to the object's end; the grasp misses if this point is beside the object", "(0 m, 0 m)")}, True),
    "carry": Verb("moves a held object horizontally", {"object": _GRIPPED, "direction": _DIRECTION, "distance": _FAR}, True),
    "place": Verb("puts down the held object", {"object": _GRIPPED, "on": PropertySpec((OBJECT,), "the support"), "at": PropertySpec((POINT2,), "place on the support", "(0 m, 0 m)")}, True),
    "rotate": Verb("turns a held object about the vertical", {"object": _GRIPPED, "angle": PropertySpec((AN_ANGLE,), "angle, anticlockwise as seen from above")}, True),
    "tilt": Verb("tilts a held object, as for pouring", {"object": _GRIPPED, "angle": PropertySpec((AN_ANGLE,), "how far"), "direction": PropertySpec((AN_ANGLE, DIRECTION), "direction in which its top moves", "0 deg")}, True),
    "drop": Verb("opens the hand, so that the object falls", {"object": _GRIPPED}, False),
    "open": Verb("grasps a handle, moves it along its joint in the positive direction, and releases it", {"object": _HANDLE, "joint": _JOINT, "far": _ALONG, "at": _WHERE}, True),
    "close": Verb("grasps a handle, moves it along its joint in the negative direction, and releases it", {"object": _HANDLE, "joint": _JOINT, "far": _ALONG, "at": _WHERE}, True),
}  # fmt: skip

#: Verbs of each robot model. They take the time given by `for TIME`.
ROBOTS: dict[str, dict[str, Verb]] = {
    "panda": _ARM,
    "arm": _ARM,
    "car": {
        "forward": Verb("drives ahead in its lane", {"distance": _FAR}, True),
        "turn": Verb("drives to the next crossing, turns into the road on that side, and drives a little further", {"direction": _SIDE}, True),
        "change_lane": Verb("moves to the adjacent lane", {"direction": _SIDE}, True),
        "stop": Verb("brakes to a stop in its lane", {}, True),
        "go_to": Verb("drives the shortest way along its roads to the point of the roads that is nearest to an object", {"to": PropertySpec((OBJECT,), "the object")}, True),
    },
    "walker": {
        "move": Verb("walks straight ahead, at most up to an obstacle", {"distance": _FAR}, True),
        "back": Verb("walks straight backwards, at most up to an obstacle", {"distance": _FAR}, True),
        "go_to": Verb("walks the shortest way around obstacles until an object is within reach, and turns to it", {"to": PropertySpec((OBJECT,), "the object")}, True),
        "turn": Verb("turns on the spot", {"direction": _SIDE, "angle": _BY}, True),
        "look": Verb("looks up or down", {"angle": PropertySpec((AN_ANGLE,), "angle above the horizontal; negative: below", least=-1.5, most=1.5)}, True),
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
