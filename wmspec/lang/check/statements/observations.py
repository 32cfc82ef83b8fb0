"""Checks observations: cameras, times and recorded channels, and the film of a task."""

from __future__ import annotations

from typing import cast

from wmspec.core.places import Location
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import constant
from wmspec.lang.check.ir import ir
from wmspec.lang.check.types.types import A_TIME, CAMERA, CHANNEL, List
from wmspec.lang.parse import syntax as s


class Observations:
    """Checks `observe` statements; an error is reported and raises `Failed`."""

    def __init__(self, check: Expressions) -> None:
        self.check = check

    def observe(self, observe: s.Observe) -> ir.Observation:
        """Return the observation of a camera at times."""
        camera = self.check.value(observe.camera, (CAMERA,), "`observe`").expr
        assert isinstance(camera, ir.Value)  # the grammar allows names only, and factors are refused
        times = self.check.value(observe.times, (List(A_TIME), A_TIME), "`at`")
        expr = times.expr if isinstance(times.type, List) else ir.Items(items=(times.expr,))
        if expr == ir.Items(items=()):
            message = "there are no times of observation here"
            self.check.fail("WMS504", message, observe.times.span, "write `[0 s, 1 s]`")
        channels = self._channels(observe.channels) if observe.channels else ("rgb",)
        place = Location.of(observe.span)
        return ir.Observation(camera=str(camera.value), times=expr, channels=channels, place=place)

    def film(self, film: s.Film) -> ir.Film:
        """Return the film of a camera between two times."""
        camera = self.check.value(film.camera, (CAMERA,), "`film`").expr
        assert isinstance(camera, ir.Value)
        start, end = (
            None if e is None else self.check.value(e, (A_TIME,), "`film`").expr for e in (film.start, film.end)
        )
        if film.start is not None and film.end is not None:
            first, last = (None if e is None else constant(e) for e in (start, end))
            if first is not None and first < 0:
                self.check.fail("WMS304", "a film begins at 0 s or later", film.start.span, "write `0 s`")
            if first is not None and last is not None and last <= first:
                self.check.fail("WMS304", "this film ends before it begins", film.end.span, "write a later time")
        return ir.Film(camera=str(camera.value), start=start, end=end, place=Location.of(film.span))

    def _channels(self, e: s.Expr) -> tuple[ir.Channel, ...]:
        expr = self.check.value(e, (List(CHANNEL), CHANNEL), "`as`").expr
        items = expr.items if isinstance(expr, ir.Items) else (expr,)
        channels = [i.value for i in items if isinstance(i, ir.Value)]
        if len(channels) < len(items) or not channels:
            self.check.fail("WMS304", "channels must be constant", e.span, "write `[rgb, depth, ids]`")
        if len(set(channels)) < len(channels):
            self.check.fail("WMS202", "a channel is named twice here", e.span, "remove one")
        return cast(tuple[ir.Channel, ...], tuple(channels))
