"""Table of functions: computations and measurements."""

from __future__ import annotations

from dataclasses import dataclass, field

from wmspec.lang.check.types.types import (
    A_LENGTH,
    A_NUMBER,
    A_TIME,
    AN_ANGLE,
    CAMERA,
    COLOR,
    COUNTED,
    ITEM,
    JOINT,
    OBJECT,
    PATH,
    PICTURE,
    PLACE,
    POINT3,
    QUANTITY,
    RELATION,
    TRUTH,
    VIEWER,
    List,
    Quantity,
    Type,
)
from wmspec.lang.check.types.units import SPEED, VOLUME


@dataclass(frozen=True)
class Function:
    """A function: its parameters and result type.

    `options` are optional named parameters, written `name: value`; the Python parameter of a keyword has a trailing
    `_`. A list may replace a single parameter if the result is a truth value, a quantity or a word; the result is then
    a list. With `repeated`, the last parameter may occur any number of times.

    `measured` is the implementation of a measurement, `module:function`, called with an `Observed` and the arguments
    (names of bodies and cameras). A function that `chooses` among bodies by another measure receives a `Measured`.
    `moments` is the number of moments that show the value: 1 for a state, 2 for a change, 3 for a course.
    """

    meaning: str
    parameters: tuple[Type, ...]
    result: Type
    measured: str = ""
    options: dict[str, Type] = field(default_factory=dict)
    repeated: bool = False
    chooses: bool = False
    moments: int = 1


_TIE_OPTION: dict[str, Type] = {"tie": A_NUMBER}
_VIEWER_OPTION: dict[str, Type] = {"seen_from": VIEWER}
_AT: dict[str, Type] = {"at": A_TIME}
_DURING: dict[str, Type] = {"from": A_TIME, "to": A_TIME}
_OBJECTS = List(OBJECT)
_TRUTHS = List(TRUTH)
_FRACTION = A_NUMBER

FUNCTIONS: dict[str, Function] = {
    # places
    "toward": Function("heading from the action's object to another object", (OBJECT,), AN_ANGLE),
    "opposite": Function("opposite heading", (AN_ANGLE,), AN_ANGLE),
    "left_of": Function("place at a distance to the left of an object's middle, as seen from the front or by `seen_from`", (OBJECT, A_LENGTH), PLACE, options=_VIEWER_OPTION),
    "right_of": Function("place at a distance to the right of an object's middle, as seen from the front or by `seen_from`", (OBJECT, A_LENGTH), PLACE, options=_VIEWER_OPTION),
    "in_front_of": Function("place at a distance in front of an object's middle: nearer to the front, or to `seen_from`", (OBJECT, A_LENGTH), PLACE, options=_VIEWER_OPTION),
    "behind": Function("place at a distance behind an object's middle: further from the front, or from `seen_from`", (OBJECT, A_LENGTH), PLACE, options=_VIEWER_OPTION),
    "polar": Function("place at a distance from an object's middle, in the direction of a heading", (OBJECT, A_LENGTH, AN_ANGLE), PLACE),
    "between": Function("place halfway between two objects", (OBJECT, OBJECT), PLACE),
    # colours
    "rgb": Function("colour with these sRGB components, 0 to 1", (A_NUMBER, A_NUMBER, A_NUMBER), COLOR),
    "shade": Function("a shade of a colour, from 0 (the darkest shade) to 1 (the lightest)", (COLOR, A_NUMBER), COLOR),
    # arithmetic
    "min": Function("minimum of quantities of one kind, single or in lists", (QUANTITY,), QUANTITY, repeated=True),
    "max": Function("maximum of quantities of one kind, single or in lists", (QUANTITY,), QUANTITY, repeated=True),
    "sum": Function("sum of quantities of one kind, single or in lists", (QUANTITY,), QUANTITY, repeated=True),
    "abs": Function("absolute value", (QUANTITY,), QUANTITY),
    "floor": Function("largest whole number that is at most the number", (A_NUMBER,), A_NUMBER),
    "mod": Function("remainder of the first quantity divided by the second", (QUANTITY, QUANTITY), QUANTITY),
    "pick": Function("item of a list by its index from 0; larger indices start again at the first item", (List(ITEM), A_NUMBER), ITEM),
    "sqrt": Function("square root", (A_NUMBER,), A_NUMBER),
    "atan": Function("angle with this tangent, from -90 deg to 90 deg", (A_NUMBER,), AN_ANGLE),
    "sin": Function("sine of an angle", (AN_ANGLE,), A_NUMBER),
    "cos": Function("cosine of an angle", (AN_ANGLE,), A_NUMBER),
    # presence and size
    "count": Function("number of listed objects that exist in the instance, or number of listed values that are true", (COUNTED,), A_NUMBER),
    "any": Function("whether at least one value is true", (_TRUTHS,), TRUTH),
    "all": Function("whether all values are true", (_TRUTHS,), TRUTH),
    "volume": Function("volume of an object", (OBJECT,), Quantity(VOLUME)),
    "largest": Function("the object with the largest volume", (_OBJECTS,), OBJECT, options=_TIE_OPTION),
    "smallest": Function("the object with the smallest volume", (_OBJECTS,), OBJECT, options=_TIE_OPTION),
    "luminance": Function("how light an object's colour is, 0 to 1", (OBJECT,), A_NUMBER),
    "darkest": Function("the object with the darkest colour", (_OBJECTS,), OBJECT, options=_TIE_OPTION),
    "lightest": Function("the object with the lightest colour", (_OBJECTS,), OBJECT, options=_TIE_OPTION),
    "fits": Function("whether the first object fits into the hollow of the second without being turned; the second must be made of parts", (OBJECT, OBJECT), TRUTH),
    # motion while observed
    "speed": Function("mean speed (path length divided by time) in the window or span, or the speed at a time", (OBJECT,), Quantity(SPEED), "wmspec.runtime.questions.motion:speed", {**_DURING, **_AT}, moments=2),
    "fastest": Function("the object with the largest speed", (_OBJECTS,), OBJECT, "wmspec.runtime.questions.choices:fastest", _TIE_OPTION, chooses=True, moments=2),
    "slowest": Function("the object with the smallest speed", (_OBJECTS,), OBJECT, "wmspec.runtime.questions.choices:slowest", _TIE_OPTION, chooses=True, moments=2),
    "moved": Function("whether the object moved in the window or span", (OBJECT,), TRUTH, "wmspec.runtime.questions.motion:moved", _DURING, moments=2),
    "mover": Function("the object that moved along the longest path", (_OBJECTS,), OBJECT, "wmspec.runtime.questions.choices:mover", chooses=True, moments=2),
    "onset": Function("time at which the object first moved", (OBJECT,), A_TIME, "wmspec.runtime.questions.motion:onset", moments=3),
    "moving_time": Function("time from the object's first motion to its last", (OBJECT,), A_TIME, "wmspec.runtime.questions.motion:moving_time", moments=3),
    "first": Function("the object that moved first", (_OBJECTS,), OBJECT, "wmspec.runtime.questions.choices:first", {"tie": A_TIME}, chooses=True, moments=3),
    "longest": Function("the object that moved for the longest time", (_OBJECTS,), OBJECT, "wmspec.runtime.questions.choices:longest", _TIE_OPTION, chooses=True, moments=3),
    "heading": Function("direction from the object's first place in the window to its last, or direction of its motion at a time; above -180 and up to 180 deg, compared modulo 360 deg", (OBJECT,), AN_ANGLE, "wmspec.runtime.questions.motion:heading", _AT, moments=2),
    "heads_to": Function("of the listed objects, the one towards which the object moved most directly", (OBJECT, _OBJECTS), OBJECT, "wmspec.runtime.questions.motion:heads_to", moments=2),
    "trajectory": Function("shape of the object's path, such as `zigzag`", (OBJECT,), PATH, "wmspec.runtime.questions.motion:trajectory", moments=3),
    # states, by default the final one
    "position": Function("position of the object's middle, at the end or at a time", (OBJECT,), POINT3, "wmspec.runtime.questions.outcome:position", _AT),
    "displacement": Function("distance, at the end or at a time, of the object from its place at the start", (OBJECT,), A_LENGTH, "wmspec.runtime.questions.outcome:displacement", _AT, moments=2),
    "distance": Function("distance between the middles of two objects, at the end or at a time", (OBJECT, OBJECT), A_LENGTH, "wmspec.runtime.questions.outcome:distance", _AT),
    "relation": Function("where the first object is relative to the second, at the last observation or at a time, as the pictures show it or as `seen_from` sees it", (OBJECT, OBJECT), RELATION, "wmspec.runtime.questions.choices:relation", {**_AT, **_VIEWER_OPTION}, chooses=True),
    "at_rest": Function("whether the object is at rest, at the end or at a time", (OBJECT,), TRUTH, "wmspec.runtime.questions.outcome:at_rest", _AT, moments=2),
    "toppled": Function("whether the object has tilted by more than 45 degrees from its initial orientation, at the end or at a time", (OBJECT,), TRUTH, "wmspec.runtime.questions.outcome:toppled", _AT),
    "height": Function("height of the object's middle, at the end or at a time", (OBJECT,), A_LENGTH, "wmspec.runtime.questions.outcome:height", _AT),
    "contains": Function("whether the middle of the second object is within the axis-aligned bounding box of the first, at the end or at a time", (OBJECT, OBJECT), TRUTH, "wmspec.runtime.questions.outcome:contains", _AT),
    "angle": Function("angle of a hinge, at the end or at a time", (JOINT,), AN_ANGLE, "wmspec.runtime.questions.joints:angle", _AT),
    "extension": Function("extension of a slider, at the end or at a time", (JOINT,), A_LENGTH, "wmspec.runtime.questions.joints:extension", _AT),
    # events and their times
    "contact": Function("whether two objects touch at any time of the episode, or of the span", (OBJECT, OBJECT), TRUTH, "wmspec.runtime.questions.events:contact", _DURING, moments=3),
    "contact_time": Function("time at which two objects first touch in the episode, or in the span", (OBJECT, OBJECT), A_TIME, "wmspec.runtime.questions.events:contact_time", _DURING, moments=3),
    "touches_first": Function("of the listed objects, the one that the object touches first", (OBJECT, _OBJECTS), OBJECT, "wmspec.runtime.questions.choices:touches_first", {"tie": A_TIME}, chooses=True, moments=3),
    "highest": Function("greatest height of the object's middle in the episode, or in the span", (OBJECT,), A_LENGTH, "wmspec.runtime.questions.events:highest", _DURING, moments=3),
    "when_highest": Function("time at which the object's middle is highest in the episode, or in the span", (OBJECT,), A_TIME, "wmspec.runtime.questions.events:when_highest", _DURING, moments=3),
    # visibility
    "visible": Function("share of the picture that the object covers: minimum over the camera's pictures", (OBJECT, CAMERA), _FRACTION, "wmspec.runtime.questions.visibility:visible"),
    "occluded": Function("share of the object that other objects hide: maximum over the camera's pictures", (OBJECT, CAMERA), _FRACTION, "wmspec.runtime.questions.visibility:occluded"),
    "contrast": Function("difference (CIEDE2000) between the colours of the object and of what surrounds it in the picture: minimum over the camera's pictures", (OBJECT, CAMERA), A_NUMBER, "wmspec.runtime.questions.visibility:contrast"),
    "frame": Function("picture of a camera at a time of the episode", (CAMERA, A_TIME), PICTURE, "wmspec.runtime.questions.observed:frame", moments=2),
}  # fmt: skip

#: Functions of other languages and their names here, or the remedy for missing ones.
FUNCTION_ALIASES: dict[str, str] = {
    **dict.fromkeys(("len", "length", "number", "size", "num"), "count"),
    **dict.fromkeys(("collide", "collides", "collided", "collision", "touch", "touches", "touching", "hit", "hits"), "contact"),
    **dict.fromkeys(("collision_time", "hit_time", "touch_time", "time_of_contact"), "contact_time"),
    **dict.fromkeys(("dist", "gap", "separation"), "distance"),
    **dict.fromkeys(("velocity", "vel", "pace"), "speed"),
    **dict.fromkeys(("fell", "fallen", "falls", "tipped", "tips", "fell_over"), "toppled"),
    **dict.fromkeys(("moves", "moving", "is_moving", "has_moved"), "moved"),
    **dict.fromkeys(("stopped", "still", "resting", "stationary", "is_static"), "at_rest"),
    **dict.fromkeys(("inside", "includes", "holds"), "contains"),
    **dict.fromkeys(("pos", "location", "where"), "position"),
    **dict.fromkeys(("biggest", "greatest"), "largest"),
    **dict.fromkeys(("quickest",), "fastest"),
    **dict.fromkeys(("direction",), "heading"),
    **dict.fromkeys(("path",), "trajectory"),
    **dict.fromkeys(("x", "y", "z"), "write `position(NAME).x`, `.y` or `.z`"),
    **dict.fromkeys(("mean", "average", "avg"), "write `sum(...) / NUMBER`"),
    **dict.fromkeys(("round",), "write `floor(NUMBER + 0.5)`"),
    **dict.fromkeys(("ceil",), "write `-floor(-NUMBER)`"),
    **dict.fromkeys(("tan",), "write `sin(ANGLE) / cos(ANGLE)`"),
    **dict.fromkeys(("pow", "square"), "write `a * a`"),
    **dict.fromkeys(("exists", "present"), "write `NAME.present`"),
    **dict.fromkeys(("nearest", "closest", "farthest", "furthest"), "compare distances: `if distance(a, c) < distance(b, c) then a else b`"),
    **dict.fromkeys(("argmax", "argmin"), "name the one: `fastest`, `slowest`, `largest`, `smallest`, `first` and others take a list of objects"),
    **dict.fromkeys(("rotation", "turned", "orientation", "yaw"), "of a joint, write `angle(JOINT)`; where an object goes is `heading(NAME)`"),
}  # fmt: skip

#: The same for domains.
DOMAIN_REMEDIES: dict[str, str] = {
    **dict.fromkeys(("random", "rand", "randint", "choice", "range", "linspace"), "write `[a, b, c]`, `a .. b by c` or `a .. b in 5`; a nuisance is drawn from that, or from `a .. b`"),
    **dict.fromkeys(("gauss", "gaussian"), "did you mean `normal`?"),
}  # fmt: skip
