"""Checks the film of a task against its questions."""

from __future__ import annotations

from collections.abc import Iterable

from wmspec.core.diagnostics import Note
from wmspec.core.places import Location
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.ir import ir
from wmspec.lang.parse import syntax as s


def check_film(check: Expressions, spec: ir.TaskSpec, statements: Iterable[s.Statement]) -> None:
    """Report a film that no question uses, one of another camera than the options, and a film without a text."""
    written = list(statements)
    film = next((x for x in written if isinstance(x, s.Film)), None)
    if film is None or spec.film is None:
        return
    closed = [question for question in spec.questions if question.has_closed_pictures]
    if not closed and not any(question.asks_possible for question in spec.questions):
        message = "no question has a closed set of pictures or `answer possible`, so none is about the film"
        check.report.add("WMS502", message, film.span, "add `options orbit of ...`, or remove the film")
    spans = {Location.of(x.text.span): x.text.span for x in written if isinstance(x, s.Question)}
    for question in closed:
        place = spans.get(question.place, question.place)
        camera = answer_camera(question)
        if camera and camera != spec.film.camera:
            message = f"the film is of `{spec.film.camera}`, and the options are pictures from `{camera}`"
            notes = (Note("the question is here", place),)
            check.report.add("WMS502", message, film.camera.span, f"write `film {camera} ...`", notes)
        if not question.film_text:
            message = "this question has no `film_text`; a video model receives its sentences without the question"
            check.report.add("WMS512", message, place, 'add `film_text "..."`', severity="warning")


def answer_camera(question: ir.Question) -> str:
    """Return the camera of the requested picture if it is always the same, else an empty string."""
    answer = question.answer
    first = answer.arguments[0] if answer.kind == "call" and answer.arguments else None
    return str(first.value) if first is not None and first.kind == "value" else ""
