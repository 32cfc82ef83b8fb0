"""A page of the disagreements of a crosscheck: pictures of both engines side by side, paths and distances."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from PIL import Image

from wmspec.api.agreement import Agreement
from wmspec.api.crosscheck_page.charts import Chart, distance_chart, path_chart
from wmspec.api.loading import Tell
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.overlay import annotate
from wmspec.dataset.build.webpage import webpage
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.caches.scene_cache import SceneCache
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.compare.check import runs
from wmspec.runtime.compare.disagreement import Disagreement
from wmspec.runtime.compare.model import Comparison
from wmspec.runtime.engines.registry import engine_version, quickest_renderer
from wmspec.runtime.questions.model import TRUTH
from wmspec.runtime.questions.runs import values_of
from wmspec.runtime.questions.views import views_of
from wmspec.sim.scene.model import Scene, Shot, Trace
from wmspec.sim.scene.render.appearance import appearance_at

#: The most disagreements with pictures; the rest is listed.
MAX_SHOWN = 24
#: The most bodies with a path.
MAX_PATHS = 4
#: Side of a picture, in pixels, and its WebP quality, of 100.
SIDE, QUALITY = 320, 85


def crosscheck_page(agreement: Agreement, tell: Tell) -> str:
    """Return the page as HTML, in one file. The shown episodes are executed again, and drawn by one engine.

    `tell` receives the reason if this machine cannot draw; the page then has paths only.
    """
    shown = sorted(agreement.disagreements, key=lambda d: d not in agreement.new)
    drawer = _Drawer(agreement, tell)
    return webpage(
        __name__,
        summary={
            "share": agreement.share,
            "count": len(agreement.instances),
            "failed": len(agreement.failed),
            "planned": agreement.planned,
            "engines": [(name, engine_version(name)) for name in agreement.job.engines],
            "seed": agreement.job.seed,
        },
        shown=[drawer.entry(d) for d in shown[:MAX_SHOWN]],
        others=[_facts(agreement, d) for d in shown[MAX_SHOWN:]],
        vanished=[_facts(agreement, d) for d in agreement.vanished],
    )


def _facts(agreement: Agreement, d: Disagreement) -> dict[str, Any]:
    levels = ", ".join(f"{k} {v:.4g}" if isinstance(v, float) else f"{k} {v}" for k, v in d.factors.items())
    known = d.identity in agreement.baseline.identities
    return {"task": d.task, "index": d.index, "levels": levels, "reason": d.reason, "known": known}


@dataclass(frozen=True)
class _Episode:
    scene: Scene
    traces: tuple[Trace, Trace]
    camera: str
    bodies: tuple[str, ...]


class _Drawer:
    """Executes and draws episodes."""

    def __init__(self, agreement: Agreement, tell: Tell) -> None:
        self._agreement, self._tell = agreement, tell
        self._tasks = {task.name: task for task in agreement.tasks}
        self._results = {(c.task, c.index): c for c in agreement.instances}
        self._traces = {name: TraceCache(name) for name in agreement.job.engines}
        self._renders = RenderCache(quickest_renderer(agreement.job.engines), SIDE, SIDE)
        self._scenes, self._draws = SceneCache(), True

    def entry(self, d: Disagreement) -> dict[str, Any]:
        """Return a disagreement for the template, with pictures and charts unless it cannot be executed."""
        rows: list[dict[str, Any]] = []
        charts: list[Chart] = []
        if d.kind != "failure" and (episode := self._executed(d)) is not None:
            names = {name: i for i, name in enumerate(episode.traces[0].bodies)}
            chosen = [names[body] for body in episode.bodies]
            charts = [path_chart(episode.traces, chosen), distance_chart(episode.traces, chosen, d.began)]
            rows = list(self._pictures(episode, d.began))
        run = "" if d.run in ("", TRUTH) else d.run
        return _facts(self._agreement, d) | {"engines": d.engines, "run": run, "rows": rows, "charts": charts}

    def _executed(self, d: Disagreement) -> _Episode | None:
        task = self._tasks[d.task]
        instance, run = task.design[d.index], d.run or TRUTH
        try:
            values = values_of(task.design, instance, runs(task.design, instance)[run])
            scene = self._scenes.of(values)
            traces = (self._traces[d.engines[0]].trace(scene), self._traces[d.engines[1]].trace(scene))
        except WmsError as error:
            self._tell(f"warning: {d.task}, instance {d.index}: {error}")
            return None
        compared = self._results[d.task, d.index].comparisons
        comparison = next(c for c in compared if c.run == run and c.engines == d.engines)
        views = views_of(task.spec, values)
        camera = views[0][0] if views else scene.cameras[0].name if scene.cameras else ""
        return _Episode(scene, traces, camera, _bodies(comparison))

    def _pictures(self, episode: _Episode, began: float | None) -> Iterator[dict[str, Any]]:
        """Yield a row for the start, the divergence and the end, with a picture of each engine."""
        end = float(episode.traces[0].time[-1])
        times = {0.0: "start", end: "end"} if began is None else {0.0: "start", began: "divergence", end: "end"}
        for time, name in sorted(times.items()):
            if pictures := self._drawn(episode, time):
                yield {"name": name, "time": time, "pictures": pictures}

    def _drawn(self, episode: _Episode, time: float) -> list[str]:
        pictures = []
        for trace in episode.traces if self._draws and episode.camera else ():
            shot = Shot(episode.camera, trace.poses(time))
            try:
                frame = self._renders.draw(appearance_at(episode.scene, time), shot)
            except WmsError as error:
                self._tell(f"warning: the page has no pictures: {error}")
                self._draws = False
                return []
            pictures.append(_data(annotate(frame, episode.scene, trace, episode.camera, time)))
        return pictures


def _bodies(comparison: Comparison) -> tuple[str, ...]:
    """Return the bodies that diverge most."""
    worst = sorted(comparison.gaps, key=lambda g: -g.position)
    parted = [g for g in worst if g.began is not None] or worst
    return tuple(g.body for g in parted[:MAX_PATHS])


def _data(picture: Image.Image) -> str:
    out = io.BytesIO()
    picture.save(out, "WEBP", quality=QUALITY, method=4)
    return f"data:image/webp;base64,{base64.b64encode(out.getvalue()).decode()}"
