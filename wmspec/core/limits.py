"""Size limits of untrusted input, and their messages."""

from __future__ import annotations

from dataclasses import dataclass

from wmspec.core.diagnostics import WmsError


class TooLarge(WmsError):
    """Input exceeds a limit."""


@dataclass(frozen=True)
class Limit:
    """An upper bound with its unit and remedy."""

    most: int
    unit: str
    help: str = "make it simpler"

    @property
    def sentence(self) -> str:
        """The predicate of the message, such as `has more than 100 levels of nesting`."""
        return f"has more than {self.most:,} {self.unit}"

    def exceeded(self) -> TooLarge:
        """Return the error to raise."""
        return TooLarge(self.sentence, help=self.help)


RIGHT_FILE = "is this the right file?"

#: A binary file; a hand-written file.
FILE_BYTES = Limit(100_000_000, "bytes", RIGHT_FILE)
XML_BYTES = Limit(4_000_000, "bytes", RIGHT_FILE)
#: A table or a manifest.
TABLE_BYTES = Limit(500_000_000, "bytes", RIGHT_FILE)
#: A Parquet file: rows, and what it unpacks to.
TABLE_ROWS = Limit(1_000_000, "rows", "split it into several files")
UNPACKED_BYTES = Limit(500_000_000, "bytes after unpacking", RIGHT_FILE)
#: An image: 8192 x 8192.
PIXELS = Limit(2**26, "pixels", "save it smaller")
#: A mesh: points, and corners of faces.
POINTS = Limit(1_000_000, "points or corners")
#: A composed USD stage, and a stage used as an asset.
COMPOSED_PRIMS = Limit(200_000, "prims after composition")
PRIMS = Limit(20_000, "prims")
#: The API schemas of a prim.
SCHEMAS = Limit(200, "API schemas", "apply those that are needed")
#: Cameras of a stage, each of which takes milliseconds to read.
CAMERAS = Limit(1_000, "cameras", "deactivate those that are not needed")
#: The layers of a stage: number, total size, and time to read them.
LAYERS = Limit(5_000, "layers")
LAYER_BYTES = Limit(2_000_000_000, "bytes in its layers", RIGHT_FILE)
LAYER_SECONDS = Limit(300, "seconds of reading")
#: A variable expression in an asset path, with its variables expanded.
EXPRESSION_LENGTH = Limit(4_000, "characters in a variable expression")
#: An XML file.
XML_ELEMENTS = Limit(20_000, "elements")
XML_DEPTH = Limit(100, "levels of nesting")
#: The path of an output folder.
FOLDERS = Limit(200, "folders in its path", "choose a folder that is not as deep")
#: The folder of a dataset.
FOLDER_FILES = Limit(1_000_000, "files", RIGHT_FILE)
#: Libraries of a spec: depth of `use`, and total number.
LIBRARY_DEPTH = Limit(50, "libraries that use one another in a row", "let the spec use them itself")
LIBRARIES = Limit(500, "libraries, each counted as often as it has a name of its own", "use each of them once")
#: An unpacked trace.
TRACE_BYTES = Limit(2_000_000_000, "bytes", RIGHT_FILE)
#: An episode: 10 minutes, and samples times bodies.
EPISODE_SECONDS = Limit(600, "seconds", "shorten the episode")
EPISODE_POSES = Limit(20_000_000, "poses, samples times bodies", "shorten the episode or use fewer bodies")
#: All tasks of a dataset.
INSTANCES = Limit(10_000_000, "instances", "generate fewer: use --per-task")
#: Number of draws of a group that are tried for balanced answers.
MAX_DRAWS = 32
