"""What `wmspec check --try` prints."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from wmspec.api.trying import TriedMeasure, TriedQuestion, TriedTask

#: Maximum number of answers listed for a question.
MAX_ANSWERS = 12

#: What to do about a gate that rejects instances, by its name.
REMEDIES = {
    "alike": "let the options differ more, or name another colour or place for one of them",
    "balance": "cross the states before and after the violation, so that half of each group is possible",
    "cause": "let the event need one of the candidates and no other",
    "disagreement": "move the outcome away from edges and from long chains of contacts; `wmspec crosscheck` explains",
    "ensure": "change the scene so that the condition holds, or remove it",
    "illegible": "show it longer, larger or further apart, look from nearer, or write `legibility off`",
    "invalid": "ask for what always has a value, or `ensure` that it has one",
    "margin": "let the outcomes differ more, or lower the bound",
    "overlap": "move the objects apart",
    "unchanged": "let the change be one in every instance",
    "unseen": "move the object or the camera; if it may be hidden, write `may hide OBJECT` or `seen OBJECT at [TIMES]`",
    "unstable": "move the outcome away from the edge at which a nudge of 0.5 mm changes it",
}


class CountType(click.IntRange):
    """A number of instances; explains the place of the option if a file follows it."""

    name = "integer"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number."""
        if isinstance(value, str) and not value.lstrip("-").isdigit():
            self.fail(f"`{value}` is not a number; write `--try` after the specs, or `--try=4`", param, ctx)
        return super().convert(value, param, ctx)


def print_trials(trials: Iterable[TriedTask]) -> None:
    """Print tried tasks to standard output, and warnings to standard error."""
    for task in trials:
        engines = ", ".join(task.engines)
        click.echo(f"{task.name}: tried {task.instances} instance{'s' * (task.instances != 1)} in {engines}")
        for question in task.questions:
            click.echo("\n".join(_lines(question)))
            if question.answers.shift:
                click.echo(f"warning: {task.name}, {question.name}: {question.answers.shift}", err=True)
            for level in question.lost:
                click.echo(f"warning: {task.name}, {question.name}: no instance with {level} is kept", err=True)
            if question.fault:
                click.echo(f"error: {task.name}, {question.name}: {question.fault}", err=True)


def print_engines_hint(trials: Iterable[TriedTask]) -> None:
    """Say how to compare engines, if one was asked and others are installed."""
    engines = {engine for task in trials for engine in task.engines}
    if len(engines) != 1:
        return
    from wmspec.runtime.engines.registry import select_backends  # imports what a check without trial does not need

    if len(select_backends("all")) > 1:
        click.echo(f"only {engines.pop()} was asked; `--try -b all` finds disagreement of engines")


def _lines(question: TriedQuestion) -> Iterator[str]:
    from wmspec.dataset.build.manifest import top_reasons

    yield f"  {question.name}: {question.kept} kept, {sum(question.rejected.values())} rejected"
    for reason, line in top_reasons(question.rejected, question.examples).items():
        yield f"  {line}"
        if reason in REMEDIES:
            yield f"      help: {REMEDIES[reason]}"
    for word, counts in (("kept", question.answers.kept), ("rejected", question.answers.rejected)):
        if counts:
            yield f"    answers {word}: {_histogram(counts)}"
    if question.kept:
        faulty = [measure for measure in question.measures if measure.share < 1]
        yield f"    legible: {question.legible:.0%}"
        yield from (f"      {_measure(measure)}" for measure in (faulty or question.measures))


def _histogram(counts: Mapping[str, int]) -> str:
    often = sorted(counts.items(), key=lambda one: (-one[1], one[0]))
    more = f", and {len(often) - MAX_ANSWERS} more" if len(often) > MAX_ANSWERS else ""
    return ", ".join(f"{answer} {count}" for answer, count in often[:MAX_ANSWERS]) + more


def _measure(measure: TriedMeasure) -> str:
    limit = f"at {'most' if measure.at_most else 'least'} {measure.bound:g} {measure.unit}".rstrip()
    return f"{measure.name}: {'most' if measure.at_most else 'least'} {measure.worst:.3g}, {limit}: {measure.share:.0%}"
