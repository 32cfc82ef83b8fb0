"""How large may be what others wrote, whatever its format, and what is said of it when it is larger."""

from __future__ import annotations

from dataclasses import dataclass

from wmspec.core.diagnostics import WmsError


class TooLarge(WmsError):
    """Something is larger than anything of its kind that people make."""


@dataclass(frozen=True)
class Limit:
    """The most that there may be of something."""

    most: int
    unit: str
    help: str = "make it simpler"

    @property
    def sentence(self) -> str:
        """What is wrong with what has more."""
        return f"has more than {self.most:,} {self.unit}"

    def exceeded(self) -> TooLarge:
        """The error to raise."""
        return TooLarge(self.sentence, help=self.help)


RIGHT_FILE = "is this the right file?"

#: Of a file, and of one that is written by hand.
BYTES = Limit(100_000_000, "bytes", RIGHT_FILE)
MARKUP = Limit(4_000_000, "bytes", RIGHT_FILE)
#: Of a table, and of what is said of a dataset.
RECORDS = Limit(500_000_000, "bytes", RIGHT_FILE)
#: Of a picture: 8192 x 8192.
PIXELS = Limit(2**26, "pixels", "save it smaller")
#: Of a mesh: its points and the corners of its faces.
POINTS = Limit(1_000_000, "points or corners")
#: Of a USD stage as it is composed, and of one that an object is made of.
COMPOSED = Limit(200_000, "prims when its references are followed")
PRIMS = Limit(20_000, "prims")
#: Of an XML file.
ELEMENTS = Limit(20_000, "elements")
DEPTH = Limit(100, "levels of nesting")
#: Of the path of what is written.
FOLDERS = Limit(200, "folders in its path", "choose a folder that is not as deep")
#: Of the libraries that a spec uses: each above the other, and altogether.
LIBRARY_DEPTH = Limit(50, "libraries that use one another in a row", "let the spec use them itself")
LIBRARIES = Limit(500, "libraries, each counted as often as it has a name of its own", "use each of them once")
#: Of a trace, unpacked.
TRACE = Limit(2_000_000_000, "bytes", RIGHT_FILE)
#: Of an episode: 10 minutes; and of its bodies' poses together, samples times bodies.
SECONDS = Limit(600, "seconds", "let it last less long")
POSES = Limit(20_000_000, "poses, samples times bodies", "let it last less long, or have fewer bodies")
#: Of all tasks of a dataset.
INSTANCES = Limit(10_000_000, "instances", "make some of them: give --per-task")
#: So many draws of a group are tried for balanced answers.
MOST_DRAWS = 32
