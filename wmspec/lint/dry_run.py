"""Trying a spec out: the scenes of a sample of instances and counterfactuals are built, nothing is executed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from wmspec.check import units
from wmspec.check.evaluate import parts
from wmspec.check.ir import Call, Counterfactual, TaskSpec
from wmspec.check.verbs import VERBS
from wmspec.design.depend import Dependencies
from wmspec.design.describe import told_of
from wmspec.design.design import Design, Instance
from wmspec.diagnostics import Diagnostic, ImpossibleValue, Note, Report, WmsError
from wmspec.layout.values import Values
from wmspec.layout.view import facing, front
from wmspec.lint.options import asked, compare
from wmspec.lint.overlap import overlaps
from wmspec.lint.pictured import pictured
from wmspec.lint.rules import Doubt, doubts, idle_requires, short_sample
from wmspec.lint.visibility import blind
from wmspec.parse.load import pointed
from wmspec.places import Location
from wmspec.stage.agents import without
from wmspec.stage.document import Document
from wmspec.stage.episode import built

#: How many instances are built, and how many of them with every counterfactual.
TRIED, TRIED_CHANGED = 12, 4

#: What follows from the place or the turn of something else, as it should.
_FOLLOWS = ("pose", "way", "form", "there", "start")


def trial(spec: TaskSpec, report: Report) -> int:
    """Report what goes wrong with the values of a spec; returns the number of its instances (0 if there are none).

    What robots do is left out.
    """
    own = Report()
    size = 0
    try:
        _doubt(doubts(spec), own)
        design = Design(spec)
        size = len(design)
        _doubt(idle_requires(spec, design.conditions), own)
        _doubt(short_sample(spec, len(design.blocks.members(0))), own)
        tried = _Trial(without(spec), design, own)
        for count, index in enumerate(design.sample(TRIED)):
            with tried.telling():
                tried.instance(design[index], count < TRIED_CHANGED)
        for question in spec.questions:
            with tried.telling():
                compare(question, design, own)
    except WmsError as error:
        own.include(_coded(error))
    report.include(pointed(own.diagnostics))
    return size


def _doubt(found: Iterable[Doubt], report: Report) -> None:
    for code, message, place, help in found:
        report.add(code, message, place, help, severity="warning")


class _Trial:
    """Builds the scenes of instances. What is found in several of them is told of the first."""

    def __init__(self, spec: TaskSpec, design: Design, report: Report) -> None:
        self.spec = spec
        self.design = design
        self.report = report
        self.depend = Dependencies(spec)
        self.things = {t.name for t in spec.things}
        self.asset = {t.name: t.of for t in spec.things if t.kind == "object"}
        self.told: set[object] = set()

    def instance(self, instance: Instance, changed: bool) -> None:
        """One instance, with its counterfactuals if `changed`. Raises WmsError if it cannot be staged."""
        values = Values(self.spec, instance.values, None, instance.key)
        truth = built(values)
        self.overlapping(values, instance)
        self.blind(values)
        self.turned(values)
        self.late(values, instance)
        for question in self.spec.questions:
            time = pictured(question, values) if asked(question, values) else None
            if time is not None and self.outside(time, values, question.place):
                time = None
            for change in question.counterfactuals if changed else ():
                if change.owner in self.things:
                    with self.telling():
                        otherwise = Values(self.spec, instance.values, change, instance.key)
                        if time is not None:
                            self.outside(time, otherwise, change.place)
                        self.changes(change, truth, built(otherwise), instance)
                        if change.change == "state":
                            self.overlapping(otherwise, instance)

    @contextmanager
    def telling(self) -> Iterator[None]:
        """Report impossible values, but those at places where another instance had some, and go on."""
        try:
            yield
        except WmsError as error:
            self.report.include(d for d in _coded(error) if self.new(str(d.place)))

    def new(self, *what: object) -> bool:
        """Whether this was not told yet."""
        fresh = what not in self.told
        self.told.add(what)
        return fresh

    def overlapping(self, values: Values, instance: Instance) -> None:
        """Objects inside one another at the start."""
        for pair in overlaps(values):
            if self.new("overlap", pair.first, pair.second):
                begun = f"under `{values.change.name}`" if values.change else "at the start"
                what = f"`{pair.second}` is {_long(pair.depth)} inside `{pair.first}` {begun}"
                note = Note(f"`{pair.first}` is declared here", values.place(pair.first))
                span = values.place(pair.second)
                remedy = "move them apart, make one smaller, or exclude this with `require`"
                self.report.add("WMS601", f"{what} {told_of(self.design, instance)}", span, remedy, (note,))

    def late(self, values: Values, instance: Instance) -> None:
        """Actions that begin when the episode is over."""
        end: float = values.ref("end")
        for action in self.spec.things:
            name = action.name
            if action.kind == "action" and not VERBS[action.verb].holds and values.there(name):
                start: float = values.property(name, "start")
                if start > end - 1e-9 and self.new("late", name):
                    lasts = f"the episode lasts {units.told(end, units.TIME)} {told_of(self.design, instance)}"
                    what = f"`{name}` never happens: it begins at {units.told(start, units.TIME)}, and {lasts}"
                    span = values.place(name, "start")
                    remedy = "let it begin earlier, or set a longer `horizon`"
                    self.report.add("WMS304", what, span, remedy, severity="warning")

    def outside(self, time: float, values: Values, place: Location) -> bool:
        """Whether an option is a picture (s) of what is not executed, which is told."""
        within = values.during(time)
        if not within and self.new("outside", place):
            lasts = f"the episode, which lasts {units.told(values.ref('end'), units.TIME)}"
            what = f"a picture at {units.told(time, units.TIME)} is outside {lasts}"
            self.report.add("WMS304", what, place, "ask for an earlier one, or set a longer `horizon`")
        return not within

    def blind(self, values: Values) -> None:
        """Cameras that look at nothing that matters."""
        for camera in blind(values):
            if self.new("blind", camera):
                what = f"`{camera}` has none of what is moved or asked about in its picture"
                seen = next(o.place for o in self.spec.observations if o.camera == camera)
                remedy = "turn it with `look_at:`, widen its `fov:`, or leave it out"
                self.report.add("WMS602", what, seen, remedy, severity="warning")

    def turned(self, values: Values) -> None:
        """Cameras that have on their left what `relation` does not call so."""
        answers = (part for question in self.spec.questions for part in parts(question.answer))
        if not any(isinstance(part, Call) and part.function == "relation" for part in answers):
            return
        way = front(values)
        for observation in self.spec.observations:
            camera = observation.camera
            if facing(values, camera) != way and self.new("turned", camera):
                what = f"`{camera}` looks another way than `relation`, which goes by the world's front"
                remedy = "observe only from one side, or say in the question that it is meant as seen from the front"
                self.report.add("WMS603", what, observation.place, remedy, severity="warning")

    def changes(self, change: Counterfactual, truth: Document, altered: Document, instance: Instance) -> None:
        """A counterfactual that changes nothing, or more than it says."""
        span, differing = change.place, truth.differing(altered)
        if not differing and self.new("idle", change.name):
            self.report.add("WMS503", f"`{change.name}` changes nothing {told_of(self.design, instance)}", span)
        more = sorted(set(self.more(change, differing)))
        if more and self.new("more", change.name):
            target = f"{change.owner}.{change.property}"
            what = f"`{change.name}` changes not only `{target}` but also {' and '.join(f'`{m}`' for m in more)}"
            remedy = f"say that without `{target}`, in terms of a factor or a `let`"
            self.report.add("WMS505", what, span, remedy, severity="warning")

    def more(self, change: Counterfactual, differing: dict[str, frozenset[str]]) -> Iterator[str]:
        """Properties of other things that are said in terms of what is changed."""
        if change.value is None:
            return
        target = f"{change.owner}.{change.property}"
        for sources in differing.values():
            owned = [source.rpartition(".") for source in sources]
            if all(owner != change.owner for owner, _, _ in owned):
                others = (o for o in owned if self.asset.get(o[0]) != change.owner)  # the whole is said of each link
                found = (f"{owner}.{name}" for owner, _, name in others if name not in _FOLLOWS)
                yield from (source for source in found if target in self.depend.source(source))


def _coded(error: WmsError) -> Iterator[Diagnostic]:
    """What an error says; what has no code of its own, such as a mesh that cannot be used, is an impossible value."""
    yield from (d if d.code else replace(d, code=ImpossibleValue.code) for d in error.diagnostics)


def _long(length: float) -> str:
    return units.told(float(f"{length:.2g}"), units.LENGTH)
