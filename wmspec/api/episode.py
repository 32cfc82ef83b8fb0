"""Executed episodes: the trajectories of all bodies, and the pictures of cameras."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from os import PathLike
from pathlib import Path
from typing import Unpack

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from pxr import Usd, UsdUtils

import wmspec.sim.usd.schema  # noqa: F401  registers the schemas, which must precede the first stage
from wmspec.api.rendering import RenderOptions, renderer_of
from wmspec.core.diagnostics import Diagnostic, StageError, WmsError, suggestion
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import writing
from wmspec.dataset.build import typeset, video
from wmspec.dataset.build.overlay import annotate
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.compare.regimes import trace_regimes
from wmspec.runtime.compare.tolerance import Tolerances
from wmspec.runtime.engines import archive
from wmspec.runtime.engines.registry import info
from wmspec.sim.scene.capability import approximation_warnings, require
from wmspec.sim.scene.model import Contact, Frame, Pose, Scene, Shot, Trace
from wmspec.sim.scene.model.bounds import box_center
from wmspec.sim.scene.render.appearance import appearance_at
from wmspec.sim.scene.render.camera import find_camera
from wmspec.sim.usd import read
from wmspec.sim.usd.files import open_stage_file


@dataclass(frozen=True)
class Track:
    """The trajectory of one body, with T samples.

    `position` (T, 3) m and `orientation` (T, 4), quaternions (w, x, y, z), describe the body's frame. `linear_velocity`
    (T, 3) m/s and `angular_velocity` (T, 3) rad/s are those of the centre of mass, in world axes. `center` (T, 3) m is
    the centre of the bounding box, used by measures; for a simple shape it is the origin of the frame.
    """

    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    linear_velocity: NDArray[np.float64]
    angular_velocity: NDArray[np.float64]
    center: NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Episode:
    """One execution of a `stage` in an engine: `episode["ball"]` is the track of a body; iteration gives names."""

    stage: Usd.Stage
    scene: Scene
    trace: Trace

    def __repr__(self) -> str:
        return f"<Episode of {self.scene.name} in {self.engine}: {self.time[-1]:g} s, {len(self.bodies)} bodies>"

    @property
    def engine(self) -> str:
        """The engine that executed it."""
        return self.trace.engine

    @property
    def time(self) -> NDArray[np.float64]:
        """The times of the samples, (T,) s; the first is 0."""
        return self.trace.time

    @property
    def bodies(self) -> tuple[str, ...]:
        """The names of all bodies, in the order of `ids`."""
        return self.trace.bodies

    @property
    def movable(self) -> tuple[str, ...]:
        """The names of the bodies that can move."""
        links = {joint.path for joint in self.scene.joints}
        return tuple(b.name for b in self.scene.bodies if b.motion != "static" and b.path not in links)

    @property
    def notes(self) -> tuple[Diagnostic, ...]:
        """Warnings: substitutions, approximations, and regimes in which the engine is known to be wrong."""
        wrong = trace_regimes(self.scene, self.trace, Tolerances().event)
        warnings = (Diagnostic(regime.sentence, severity="warning") for regime in wrong)
        nearly = approximation_warnings(info(self.engine).lacks, self.scene)
        return tuple(dict.fromkeys((*self.scene.notes, *nearly, *warnings)))

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """The pairs of bodies in contact, with start and stop in seconds."""
        return self.trace.contacts

    def __getitem__(self, body: str) -> Track:
        """Return the track of a body. Raises WmsError if there is no body with that name."""
        if body not in self.bodies:
            raise WmsError(f"there is no body `{body}`; {suggestion(body, self.bodies)}")
        trace, i = self.trace, self.bodies.index(body)
        frames = Pose(trace.position[:, i], trace.orientation[:, i])
        return Track(
            position=frames.position,
            orientation=frames.orientation,
            linear_velocity=trace.linear_velocity[:, i],
            angular_velocity=trace.angular_velocity[:, i],
            center=box_center(self.scene.bodies[i], frames),
        )

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of all bodies."""
        return iter(self.bodies)

    def __len__(self) -> int:
        return len(self.bodies)

    def __contains__(self, body: object) -> bool:
        return body in self.bodies

    def views(self, camera: str = "") -> list[tuple[str, float]]:
        """Return the camera and time (s) of each picture that the stage requests; with `camera`, of this camera only.

        If the stage requests none, return the initial view of each camera. Raises WmsError if there is no such camera.
        """
        requested = [(o.camera, t) for o in self.scene.observations for t in o.times]
        views = requested or [(c.name, 0.0) for c in self.scene.cameras]
        if not camera:
            return views
        find_camera(self.scene, camera)
        times = sorted({t for c, t in views if c == camera} or {t for _, t in views})
        return [(camera, t) for t in times]

    def frame(self, camera: str, time: float, **options: Unpack[RenderOptions]) -> NDArray[np.uint8]:
        """Return the picture of a camera at a time (s), interpolated between samples: (height, width, 3), sRGB.

        Raises WmsError if there is no such camera, the time is outside the episode, or the engine cannot draw.
        """
        return self._drawn(camera, time, False, options).rgb

    def ids(self, camera: str, time: float, **options: Unpack[RenderOptions]) -> NDArray[np.int16]:
        """Return the index in `bodies` that each pixel shows, (height, width); -1 for none. Raises as `frame`."""
        return self._drawn(camera, time, False, options).ids

    def depth(self, camera: str, time: float, **options: Unpack[RenderOptions]) -> NDArray[np.float32]:
        """Return the depth of each pixel along the view axis, (height, width) m; 0 for none. Raises as `frame`."""
        distances = self._drawn(camera, time, True, options).depth
        assert distances is not None
        return distances

    def picture(
        self, camera: str, time: float, *, overlay: bool = False, **options: Unpack[RenderOptions]
    ) -> Image.Image:
        """Return the picture of `frame` as an image; with `overlay`, it shows names and paths of bodies."""
        frame = self._drawn(camera, time, False, options)
        return annotate(frame, self.scene, self.trace, camera, time) if overlay else Image.fromarray(frame.rgb)

    def sheet(self, camera: str = "", *, overlay: bool = False, **options: Unpack[RenderOptions]) -> Image.Image:
        """Return all views as a captioned sheet with a row per camera; a single view has no caption."""
        views = self.views(camera)
        if len(views) == 1:
            return self.picture(*views[0], overlay=overlay, **options)
        rows = [
            [
                (f"{each}, {time:.3g} s", self.picture(each, time, overlay=overlay, **options))
                for other, time in views
                if other == each
            ]
            for each in dict.fromkeys(camera for camera, _ in views)
        ]
        return typeset.grid(rows, _caption, 8)

    def film(
        self,
        path: str | PathLike[str],
        camera: str = "",
        *,
        rate: float = 25.0,
        overlay: bool = False,
        **options: Unpack[RenderOptions],
    ) -> Path:
        """Write the episode as .gif, or as .mp4 (needs the extra `video`), at `rate` frames per second.

        Raises WmsError if it cannot be written.
        """
        path = Path(path)
        if path.suffix.lower() not in video.WRITERS:
            raise WmsError(f"a film is a file that ends in {' or '.join(video.WRITERS)}", FilePlace(str(path)))
        camera = camera or self.views()[0][0]
        moments = (i / rate for i in range(int(self.time[-1] * rate + 1e-9) + 1))
        pictures = (self.picture(camera, moment, overlay=overlay, **options) for moment in moments)
        with writing(path):
            video.WRITERS[path.suffix.lower()](pictures, rate, path)
        return path

    def save(self, path: str | PathLike[str]) -> None:
        """Write trace and stage to an .npz file, which `load_episode` reads. Raises WmsError if that is impossible."""
        archive.save(self.stage, self.trace, Path(path), self.notes)

    def _drawn(self, camera: str, time: float, depth: bool, options: RenderOptions) -> Frame:
        find_camera(self.scene, camera)
        if not -1e-9 <= time <= self.time[-1] + 0.5 / self.scene.rate:
            raise WmsError(f"{time:g} s is outside the episode, which lasts {self.time[-1]:g} s")
        shot = Shot(camera, self.trace.poses(time))
        return renderer_of(self.engine, **options).draw(appearance_at(self.scene, time), shot, depth=depth)


def open_stage(path: str | PathLike[str]) -> Usd.Stage:
    """Open a USD stage of any tool. Raises WmsError if there is no such file, or if USD cannot open it."""
    path = Path(path)
    if not path.is_file():
        reason = "it is a folder, not a file" if path.is_dir() else "there is no such file"
        raise WmsError(reason, FilePlace(str(path)))
    quiet = UsdUtils.CoalescingDiagnosticDelegate()  # wmspec reports the messages of USD, here and in the reader
    try:
        return open_stage_file(path, str(path))
    except WmsError as error:
        raise WmsError(f"not a stage that USD can open: {error}", FilePlace(str(path))) from None
    finally:
        del quiet


def run(
    stage: Usd.Stage | str | PathLike[str], engine: str, duration: float | None = None, *, strict: bool = False
) -> Episode:
    """Execute a stage, or the stage in a file, in an engine; `duration` (s) overrides the stage's own.

    Visual content that cannot be drawn, and content that can only be approximated, is replaced and listed in the
    episode's `notes`; with `strict`, it is refused.

    Raises:
        StageError: the stage has content that cannot be executed; `diagnostics` of the error lists all of it.
        WmsError: the stage has no duration, the engine is unknown, or the engine fails.
    """
    opened = open_stage(stage) if isinstance(stage, str | PathLike) else stage
    if duration is None and read(opened, strict=strict).duration <= 0:
        name = stage if isinstance(stage, str | PathLike) else opened.GetRootLayer().identifier
        remedy = "add for instance `--for 2s` (`duration=2`)"
        raise StageError("the stage does not say how long it lasts", FilePlace(str(name)), remedy)
    return execute(opened, engine, duration, strict=strict)


def execute(stage: Usd.Stage, engine: str, duration: float | None = None, *, strict: bool) -> Episode:
    """The same for a stage that may well last a single moment."""
    scene = read(stage, strict=strict)
    if duration is not None:
        if duration * scene.rate < 0.99:  # tolerance for rounded times
            raise WmsError(
                f"{1000 * duration:g}ms: shorter than one sample; ask for at least {1000 / scene.rate:.3g}ms"
            )
        scene = replace(scene, duration=round(duration * scene.rate) / scene.rate)
    trace = executor(engine).trace(scene)
    require(info(engine).lacks, scene, strict=strict)
    return Episode(stage, scene, trace)


def load_episode(path: str | PathLike[str]) -> Episode:
    """Load an episode saved by `Episode.save` or `wmspec run -o`. Raises WmsError if the file is not one."""
    stage, trace = archive.load(Path(path))
    scene = read(stage, strict=False)
    here, place = [body.name for body in scene.bodies], FilePlace(str(path))
    if list(trace.bodies) != here:
        raise WmsError(f"its bodies are not those of its stage, {', '.join(here)[:200]}", place)
    if len(trace.time) != (samples := round(scene.duration * scene.rate) + 1) and scene.duration > 0:
        raise WmsError(f"it has {len(trace.time):,} samples; its stage lasts for {samples:,}", place)
    return Episode(stage, scene, trace)


@cache
def executor(engine: str) -> TraceCache:
    """Return the executor of an engine; it executes equal scenes once."""
    return TraceCache(engine)


def _caption(text: str, width: int) -> Image.Image:
    return typeset.paragraph(text, typeset.Style(15), width)
