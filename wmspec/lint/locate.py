"""Pointing at what was written: from the places that a checked task keeps to the text itself."""

from __future__ import annotations

import re
from collections.abc import Iterator

from wmspec.check.ir import Location, TaskSpec
from wmspec.errors import WmsError
from wmspec.parse.load import located, read_source
from wmspec.parse.source import Source, Span

_PLACE = re.compile(r"([^\s:;][^:;]*):(\d+):(\d+): ")


class Pointer:
    """Finds the text of places in the files of a task; each file is read once."""

    def __init__(self, spec: TaskSpec) -> None:
        self._places = {str(place): place for place in _places(spec)}
        self._sources: dict[str, Source] = {}

    def span(self, place: Location) -> Span:
        """The text at a place."""
        source = self._source(place.file)
        return Span(source, min(place.start, len(source.text)), min(place.end, len(source.text)))

    def said(self, message: str) -> tuple[str, Span]:
        """A message without the place that it begins with, and the text there."""
        match = _PLACE.search(message)
        if match is None:
            return message, Span(Source("<spec>", " "), 0, 0)
        told = message[: match.start()] + message[match.end() :]
        place = self._places.get(match[0][:-2])
        return told, self.span(place) if place else self._rest_of_line(match)

    def _rest_of_line(self, match: re.Match[str]) -> Span:
        source = self._source(match[1])
        lines = source.text.split("\n")
        start = sum(len(line) + 1 for line in lines[: int(match[2]) - 1]) + int(match[3]) - 1
        return Span(source, start, start + len(source.text[start:].partition("\n")[0].rstrip()))

    def _source(self, name: str) -> Source:
        if name not in self._sources:
            try:
                self._sources[name] = read_source(located(name))
            except WmsError:  # a task that was made in Python
                self._sources[name] = Source(name, " ")
        return self._sources[name]


def _places(spec: TaskSpec) -> Iterator[Location]:
    for thing in spec.things:
        yield thing.place
        yield from (setting.place for setting in thing.properties.values())
    for question in spec.questions:
        yield from (question.place, *(c.place for c in question.counterfactuals))
    if spec.plan.place:
        yield spec.plan.place
    yield from (item.place for items in (spec.factors, spec.requires, spec.observations) for item in items)
