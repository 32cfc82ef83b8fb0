"""Receipts: signed scores of a submission, by who holds the answers."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd

from wmspec import __version__
from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.models import prompt as prompts
from wmspec.eval.models import results
from wmspec.eval.models.model import Reply
from wmspec.eval.models.question import questions
from wmspec.eval.models.request import Ask
from wmspec.eval.publish.questions import Published
from wmspec.eval.publish.secret import Secret
from wmspec.eval.publish.submission import Submission
from wmspec.eval.replies import PARSER_VERSION
from wmspec.eval.report.intervals import Estimate
from wmspec.eval.report.questions import Questions
from wmspec.eval.report.replies import replies
from wmspec.eval.report.tables import Table, tables

#: Format of receipts.
FORMAT = 1
_NO_LINE = Reply(error="the submission has no reply")


def scored(dataset: DatasetReader, published: Published, submission: Submission, secret: Secret) -> list[results.Row]:
    """Return the scored rows of a submission, as `wmspec evaluate` writes them, with private ids and answers.

    Raises WmsError if the published questions are not those of the dataset and the secret.
    """
    rows = list(_rows(dataset, published, submission, secret))
    if len(rows) != len(published.questions):
        raise WmsError(
            f"{len(published.questions) - len(rows):,} published questions are not in the dataset",
            help="give the dataset and the secret that they were exported with",
        )
    return rows


def receipt(
    dataset: DatasetReader,
    published: Published,
    submission: Submission,
    secret: Secret,
    date: str,
    rows: list[results.Row],
) -> dict[str, Any]:
    """Return the signed receipt of a submission: digests, model, prompt, outcomes, and scores with intervals.

    `rows` are its scored rows.
    """
    made = tables(replies(pd.DataFrame(rows), Questions.read(dataset.folder)))
    content = {
        "format": FORMAT,
        "questions": published.digest,
        "count": len(rows),
        "submission": submission.digest,
        "model": submission.about.model,
        "prompt": submission.about.prompt,
        "notes": submission.about.notes,
        "date": date,
        "versions": {"wmspec": __version__, "parser": str(PARSER_VERSION)},
        "outcomes": submission.outcomes(published),
        "scores": {table.kind: _table(table) for table in made},
    }
    return content | {"signature": secret.sign(content)}


def _rows(
    dataset: DatasetReader, published: Published, submission: Submission, secret: Secret
) -> Iterator[results.Row]:
    template = prompts.load("default")
    ids = [row["id"] for task in dataset.tasks for row in dataset.rows(task, ["id"])]
    for question in questions(dataset, ids, pictures=False):
        public = secret.public_id(question.task, question.id)
        if public in published.questions:
            labels = published.questions[public][1]
            reply = submission.replies.get(public, _NO_LINE)
            row = results.row(Ask(question, template), reply, submission.about.model, submission.about.prompt)
            yield results.score(row | {"labels": labels})


def _table(table: Table) -> dict[str, Any]:
    """Return the scores of the only system of a table."""
    (line,) = table.lines
    return {
        "average": _number(line.average),
        "chance": _finite(line.chance),
        "answered": _finite(line.parsed),
        "dimensions": {name: _number(value) for name, value in line.dimensions.items()},
        "tasks": {name: _number(value) for name, value in sorted(line.tasks.items())},
    }


def _number(estimate: Estimate) -> dict[str, Any]:
    return {name: _finite(value) if isinstance(value, float) else value for name, value in asdict(estimate).items()}


def _finite(value: float) -> float | None:
    """Return a number for a receipt. A whole number is an int, since other JSON writers turn 1.0 into 1."""
    if math.isnan(value):
        return None
    rounded = round(value, 6)
    return int(rounded) if rounded.is_integer() else rounded


def read(path: Path, secret: Secret) -> dict[str, Any]:
    """Read a receipt, with its signature.

    Raises WmsError if it is none, or if it was not signed with this secret or was edited since.
    """
    try:
        content: Any = json.loads(read_bytes(path))
        signature = content.pop("signature")
        known = content["format"] == FORMAT and isinstance(content["scores"], dict)
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        raise WmsError("this is no receipt", FilePlace(str(path)), "`wmspec score` writes receipts") from None
    try:
        signed = secret.is_signed(content, signature)
    except (ValueError, RecursionError):
        signed = False
    if not signed or not known:
        raise WmsError(
            "the receipt is forged, or was edited", FilePlace(str(path)), "score the submission again, with its secret"
        )
    found: dict[str, Any] = content | {"signature": signature}
    return found
