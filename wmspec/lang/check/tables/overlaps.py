"""Words that overlap: what one of them names, the other names as well.

Options must exclude one another. `planks` beside `wood` do not: who answers "wood" of planks is right.
"""

from __future__ import annotations

import re
from functools import lru_cache

#: Kinds of things by the word for all of them. A kind of a kind is a kind as well.
KINDS: dict[str, tuple[str, ...]] = {
    # materials
    "wood": ("planks", "plank", "board", "boards", "parquet", "plywood", "timber", "oak", "walnut", "pine", "bamboo"),
    "stone": ("marble", "granite", "slate", "sandstone", "limestone", "rock", "cobble", "pebble"),
    "rock": ("granite", "marble", "slate"),
    "metal": ("steel", "iron", "copper", "brass", "aluminium", "aluminum", "gold", "silver", "lead", "tin", "chrome"),
    "fabric": ("cloth", "weave", "carpet", "felt", "linen", "cotton", "wool", "silk", "velvet", "denim", "textile"),
    "textile": ("cloth", "weave", "carpet", "felt"),
    "plastic": ("vinyl", "acrylic", "nylon"),
    "pattern": ("checker", "stripes", "dots"),
    "ceramic": ("tiles", "tile", "porcelain", "brick"),
    "plant": ("grass", "leaf", "tree", "flower", "flowers", "bush", "cactus"),
    # shapes
    "box": ("cube", "cuboid", "carton", "crate"),
    "cuboid": ("cube",),
    "sphere": ("ball",),
    "ball": ("sphere",),
    "ring": ("torus",),
    "torus": ("ring",),
    "rectangle": ("square",),
    "ellipse": ("circle",),
    "oval": ("ellipse", "circle"),
    "triangle": ("wedge",),
    # colours
    "blue": ("navy", "azure", "cobalt", "turquoise", "teal", "indigo"),
    "red": ("crimson", "scarlet", "maroon", "ruby"),
    "green": ("lime", "olive", "mint", "emerald"),
    "yellow": ("lemon", "amber"),
    "purple": ("violet", "lilac", "lavender", "magenta", "indigo"),
    "violet": ("purple",),
    "brown": ("oak", "walnut", "tan", "chestnut", "beige"),
    "white": ("chalk", "ivory"),
    "gray": ("grey", "slate", "silver"),
    "grey": ("gray", "slate", "silver"),
    # things
    "cup": ("mug", "teacup", "beaker", "tumbler"),
    "glass": ("tumbler", "wineglass", "beaker"),
    "container": ("vessel", "box", "basket", "bucket", "bin", "can", "jar", "bottle", "drawer", "bag"),
    "vessel": ("cup", "glass", "bowl", "pot", "pan", "kettle", "teapot", "vase", "jug", "jar", "bottle", "bucket", "flask"),
    "pot": ("teapot",),
    "dish": ("plate", "bowl"),
    "fruit": ("apple", "pear", "banana", "tangerine", "orange", "lemon", "grape"),
    "vegetable": ("carrot", "tomato", "cabbage"),
    "food": ("fruit", "vegetable", "bread", "cake", "cheese", "egg"),
    "furniture": ("table", "chair", "seat", "sofa", "bed", "shelf", "cupboard", "wardrobe", "bench"),
    "table": ("desk",),
    "seat": ("chair", "stool", "sofa", "bench", "armchair"),
    "chair": ("armchair", "stool"),
    "sofa": ("couch",),
    "couch": ("sofa",),
    "vehicle": ("car", "truck", "lorry", "bus", "van", "bicycle", "tram"),
    "car": ("taxi", "van"),
    "animal": ("dog", "cat", "bird", "horse", "duck"),
    "tool": ("hammer", "saw", "wrench", "screwdriver", "knife"),
    "toy": ("block", "doll", "train"),
    "building": ("house", "tower", "shed"),
    "picture": ("photo", "painting", "drawing"),
    "thing": ("object", "container", "food", "furniture", "vehicle", "animal", "tool", "toy", "plant", "lamp", "block"),
    "object": ("thing",),
    "shape": ("box", "sphere", "cylinder", "cone", "capsule", "ring", "rectangle", "ellipse", "triangle"),
    # answers
    "none": ("neither",),
    "neither": ("none",),
}  # fmt: skip

#: Words that change what the others mean: a phrase with one of them is no kind of the phrase without.
_DECIDING = {
    "no", "not", "never", "none", "neither", "without", "only", "both", "half", "one", "two", "three", "four", "five",
    "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
}  # fmt: skip
_ARTICLES = {"a", "an", "the"}
_WORD = re.compile(r"[^\W_]+(?:[.'’-][^\W_]+)*")


def is_kind_of(phrase: str, other: str) -> bool:
    """Whether what a phrase names is named by the other as well: `planks` by `wood`, `the desk lamp` by `the lamp`.

    The last words must be equal, or the one a kind of the other. Every word before it in the other must be in the
    phrase, which may have more. Articles and letter case do not count.
    """
    mine, its = _words(phrase), _words(other)
    if not mine or not its or mine == its:
        return False
    more = set(mine[:-1]) - set(its[:-1])
    if set(its[:-1]) - set(mine[:-1]) or more & _DECIDING or any(word[0].isdigit() for word in more):
        return False
    return mine[-1] == its[-1] or mine[-1] in _kinds(its[-1])


def _words(phrase: str) -> tuple[str, ...]:
    return tuple(word for word in _WORD.findall(phrase.lower()) if word not in _ARTICLES)


@lru_cache
def _kinds(word: str) -> frozenset[str]:
    """Return the kinds of a thing, and their kinds."""
    found: set[str] = set()
    rest = [word]
    while rest:
        new = set(KINDS.get(rest.pop(), ())) - found
        found |= new
        rest += sorted(new)
    return frozenset(found)
