"""Opens the layers of an untrusted stage: regular files only, within bounds of count, size and time, probed first."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from time import monotonic

from pxr import Ar, Sdf, Tf

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import FILE_BYTES, LAYER_BYTES, LAYER_SECONDS, LAYERS
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import NotARegularFile, open_file, regular_file
from wmspec.sim.usd.probe import require_readable

#: Text layers up to this size that name no other file are opened without a probe: they cannot do harm.
SMALL = 16_384


class LayerFiles:
    """The layers of a stage by identifier. `open` checks a file before USD opens it."""

    def __init__(self) -> None:
        self._layers: dict[str, Sdf.Layer | None] = {}
        self._bytes = 0
        self._end = monotonic() + LAYER_SECONDS.most

    @property
    def layers(self) -> list[Sdf.Layer]:
        """All layers that were opened."""
        return [layer for layer in self._layers.values() if layer is not None]

    def open(self, identifier: str) -> Sdf.Layer | None:
        """Return a layer; None if it is missing or no layer, which USD reports when it opens the stage.

        Raises WmsError if its file is a pipe or device, too large or damaged, or if all files exceed a bound.
        """
        if identifier not in self._layers:
            self._layers[identifier] = None
            if self.check(identifier):
                with suppress(Tf.ErrorException):  # USD reports it
                    self._layers[identifier] = Sdf.Layer.FindOrOpen(identifier)
        return self._layers[identifier]

    def check(self, identifier: str) -> bool:
        """Whether the file of a layer exists; it is checked but not opened. Raises WmsError as `open` does."""
        if len(self._layers) > LAYERS.most:
            raise LAYERS.exceeded()
        if monotonic() > self._end:
            raise LAYER_SECONDS.exceeded()
        path = Path(Ar.SplitPackageRelativePathOuter(Sdf.Layer.SplitIdentifier(identifier)[0])[0])
        try:
            size = regular_file(path).stat().st_size
        except NotARegularFile as error:
            raise WmsError(str(error.strerror), FilePlace(path.name)) from None
        except (OSError, ValueError):
            return False
        self._bytes += size
        if size > FILE_BYTES.most:
            raise FILE_BYTES.exceeded()
        if self._bytes > LAYER_BYTES.most:
            raise LAYER_BYTES.exceeded()
        if not _is_harmless(path, size):
            require_readable(path, shown=path.name if len(self._layers) > 1 else "")
        return True


def _is_harmless(path: Path, size: int) -> bool:
    """Whether a file is small text, which USD reads quickly whatever it holds."""
    if size > SMALL:
        return False
    with open_file(path) as file:
        return file.read(8).startswith(b"#usda")
