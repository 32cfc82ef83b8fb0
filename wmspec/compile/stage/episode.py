"""The stage of one episode: all objects, joints, cameras, lights and actions of the spec as prims."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from wmspec.compile.design.design import Instance
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.motion import carrier_sources, carriers
from wmspec.compile.stage.actions import add_action
from wmspec.compile.stage.cameras import add_camera, add_light, camera_path
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.joints import add_joint, require_no_loops
from wmspec.compile.stage.object_cache import ObjectCache
from wmspec.compile.stage.objects import add_object
from wmspec.core.diagnostics import ImpossibleValue, Note, Report, WmsError
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Counterfactual, TaskSpec
from wmspec.sim.usd.version import FORMAT_VERSION

SAMPLE_RATE = 240


def document(spec: TaskSpec, instance: Instance, change: Counterfactual | None = None) -> Document:
    """Return the stage of an instance, with a counterfactual if given.

    Raises WmsError with all errors and their locations, for impossible values and infeasible actions.
    """
    return build_document(Evaluator(spec, instance.values, change, instance.key))


def build_document(values: Evaluator, objects: ObjectCache | None = None) -> Document:
    """Return the stage for the values of an instance, reusing prims of cached `objects`."""
    try:
        return _build(values, objects.add if objects else add_object)
    except WmsError as error:
        if values.change is None:
            raise
        note = Note(f"under this counterfactual, `{values.change.name}`", values.change.place)
        raise error.of(replace(d, notes=(*d.notes, note)) for d in error.diagnostics) from None


def _build(values: Evaluator, make: Callable[[Document, str, Evaluator, frozenset[str], bool], None]) -> Document:
    spec = values.spec
    doc = Document({})
    doc.add("/World", "Xform")
    _physics(doc, values)
    for scope in ("Objects", "Materials", "Cameras", "Lights"):
        doc.add(f"/World/{scope}", "Scope")
    carried, deciding = carriers(values), carrier_sources(spec)
    report = Report()
    for thing in (thing for thing in spec.things if thing.kind == "object"):
        with report.collect_errors():
            if values.is_present(thing.name):
                make(doc, thing.name, values, deciding, thing.name in carried)
    for thing in (thing for thing in spec.things if thing.kind in ("joint", "camera", "light", "robot")):
        with report.collect_errors():
            match thing.kind:
                case "joint":
                    add_joint(doc, thing, values, carried)
                case "camera":
                    add_camera(doc, thing.name, values)
                case "light":
                    add_light(doc, thing.name, values.world, values)
                case "robot":
                    from wmspec.compile.stage import robots

                    robots.add_robot(doc, thing, values)
    with report.collect_errors():
        require_no_loops(values)
    with report.collect_errors():
        _episode(doc, spec, values)
    _actions(doc, values, carried, report)
    report.stop_if_failed()
    return doc


def _actions(doc: Document, values: Evaluator, carried: dict[str, str], report: Report) -> None:
    for thing in (thing for thing in values.spec.things if thing.kind == "action"):
        with report.collect_errors():
            if values.is_present(thing.name):
                if thing.of:
                    from wmspec.compile.stage import robots

                    robots.add_action(doc, thing, values)
                else:
                    add_action(doc, thing, values, carried)


def _physics(doc: Document, values: Evaluator) -> None:
    prim = doc.add("/World/physics", "PhysicsScene")
    prim.set("physics:gravityDirection", "vector3f", (0.0, 0.0, -1.0))
    prim.set("physics:gravityMagnitude", "float", values.gravity, "world.gravity")


def _episode(doc: Document, spec: TaskSpec, values: Evaluator) -> None:
    episode = doc.add("/World/Episode", "WmsEpisode")
    episode.set("wms:formatVersion", "int", FORMAT_VERSION, uniform=True)
    episode.set("wms:task", "string", spec.name, uniform=True)
    episode.set("wms:duration", "double", values.end, "end", uniform=True)
    episode.set("wms:rate", "int", SAMPLE_RATE, uniform=True)
    doc.add("/World/Episode/Actions", "Scope")
    doc.add("/World/Episode/Observations", "Scope")
    for observation, times in observation_times(spec, values):
        prim = doc.add(f"/World/Episode/Observations/{observation}", "WmsObservation")
        prim.relate("wms:camera", camera_path(observation, values), f"{observation}.ride")
        prim.set("wms:times", "double[]", times, f"observe.{observation}", uniform=True)


def observation_times(spec: TaskSpec, values: Evaluator) -> list[tuple[str, tuple[float, ...]]]:
    """Return the observed cameras, each with its times (s) in order.

    Raises WmsError if a time is outside the episode.
    """
    end = values.end
    seen: dict[str, set[float]] = {}
    for observation in spec.observations:
        times = evaluate(observation.times, values)
        for time in times:
            if not values.during(time):
                raise ImpossibleValue(f"{time:g} s is outside the episode, which lasts {end:g} s", observation.place)
        seen.setdefault(observation.camera, set()).update(times)
    return [(camera, tuple(sorted(times))) for camera, times in seen.items()]
