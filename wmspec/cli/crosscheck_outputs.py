"""Files and annotations of `wmspec crosscheck`."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmspec.cli.annotations import github, gitlab
from wmspec.cli.common import tell, write_text
from wmspec.cli.sarif import sarif

if TYPE_CHECKING:
    from wmspec.api import Agreement
    from wmspec.core.diagnostics import Diagnostic

#: The rules of SARIF: each is a kind of disagreement.
RULES = {
    "crosscheck-answers": "Two engines answer a question differently.",
    "crosscheck-trajectories": "The trajectories of two engines are out of tolerance.",
    "crosscheck-failure": "An engine cannot execute an instance.",
}


def write_outputs(agreement: Agreement, outputs: Mapping[str, str | None]) -> None:
    """Write the requested files, and print annotations. Raises WmsError if a file cannot be written."""
    if path := outputs["junit_file"]:
        write_text(Path(path), agreement.junit())
    if path := outputs["json_file"]:
        text = _json(agreement.record())
        if path == "-":
            click.echo(text, nl=False)
        else:
            write_text(Path(path), text)
    new = diagnostics(agreement)
    if path := outputs["sarif_file"]:
        write_text(Path(path), _json(sarif(new, RULES)))
    if path := outputs["gitlab_file"]:
        write_text(Path(path), _json(gitlab(new)))
    if path := outputs["html_file"]:
        from wmspec.api.crosscheck_page import crosscheck_page

        write_text(Path(path), crosscheck_page(agreement, tell))
    choice = outputs["annotations"]
    if choice == "github" or (choice == "auto" and os.environ.get("GITHUB_ACTIONS") == "true"):
        click.echo(github(new), nl=False, err=outputs["json_file"] == "-")


def diagnostics(agreement: Agreement) -> list[Diagnostic]:
    """Return a diagnostic for each question and pair of engines with new disagreements, at the question."""
    from wmspec.core.diagnostics import Diagnostic

    specs = {task.name: task.spec for task in agreement.tasks}
    counts = {name: sum(c.task == name for c in agreement.instances) for name in specs}
    alike: dict[tuple[object, ...], list[tuple[int, str]]] = {}
    for d in agreement.new:
        run = "" if d.kind == "answers" else d.run
        alike.setdefault((d.task, d.kind, d.question, run, d.engines), []).append((d.index, d.reason))
    made = []
    for (task, kind, question, *_), every in alike.items():
        spec = specs[str(task)]
        place = spec.questions[question].place if isinstance(question, int) else spec.things[0].place
        index, reason = every[0]
        few = f"{len({i for i, _ in every})} of {counts[str(task)]} instances of `{task}` disagree"
        made.append(Diagnostic(f"{few}; in instance {index}: {reason}", place, code=f"crosscheck-{kind}"))
    return made


def _json(value: object) -> str:
    return json.dumps(value, indent=2, ensure_ascii=False) + "\n"
