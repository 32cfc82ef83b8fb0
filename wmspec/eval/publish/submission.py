"""Submissions: JSON lines, the first about the model, each other a reply to a published question."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes, regular_file
from wmspec.eval.models.model import Reply, storable
from wmspec.eval.models.prompt import FrozenModel
from wmspec.eval.publish.questions import Published
from wmspec.eval.replies import mark

#: Maximum size of a submission (bytes).
MAX_BYTES = 256 << 20
_WORDS = r"^[^\x00-\x1f\x7f-\x9f]*$"


class About(FrozenModel):
    """The first line: the digest of the questions, the model, and how it was asked."""

    questions: str = Field(pattern=r"^[0-9a-f]{64}$")
    model: str = Field(min_length=1, max_length=100, pattern=_WORDS)
    prompt: str = Field(default="default", max_length=100, pattern=_WORDS)
    notes: str = Field(default="", max_length=1000, pattern=_WORDS)


class Line(FrozenModel):
    """Another line: the public id of a question, the reply, why it ended, or why none came."""

    id: str = Field(max_length=200)
    reply: str = ""
    finish_reason: str | None = Field(default=None, max_length=40)
    error: str | None = Field(default=None, max_length=4000)


@dataclass(frozen=True)
class Submission:
    """A valid submission: its first line, replies by public id, and the digest of the file."""

    about: About
    replies: dict[str, Reply]
    digest: str

    def outcomes(self, published: Published) -> dict[str, int]:
        """Return the number of questions by outcome; those without a line are errors."""
        counts = Counter(
            "error" if id not in self.replies else _outcome(self.replies[id], shown)
            for id, shown in published.questions.items()
        )
        return dict(sorted(counts.items()))


def _outcome(reply: Reply, shown: tuple[tuple[str | None, ...], str, str]) -> str:
    options, labels, unit = shown
    if reply.failed:
        return "error"
    return mark(reply.text, options, labels, unit=unit, finish=reply.finish).outcome


def read(path: Path, published: Published | None = None) -> Submission:
    """Read a submission. Raises WmsError, with the line, if it is invalid or answers other questions."""
    try:
        if regular_file(path).stat().st_size > MAX_BYTES:
            raise WmsError(f"more than {MAX_BYTES >> 20:,} MiB", FilePlace(str(path)), "a reply needs no pictures")
        content = read_bytes(path)
        # JSON may hold other line separators, such as U+2028, at which `splitlines` would break a line.
        lines = content.decode("utf-8-sig").split("\n")
    except OSError as error:
        raise WmsError(f"cannot be read: {error.strerror}", FilePlace(str(path))) from None
    except UnicodeDecodeError:
        raise WmsError("this is not UTF-8", FilePlace(str(path)), "write JSON lines in UTF-8") from None
    if not content.strip():
        raise WmsError("the file is empty", FilePlace(str(path)), "its first line is about the model")
    about = _parse(About, lines[0], path, 1)
    if published is not None and about.questions != published.digest:
        raise WmsError("it answers other questions", FilePlace(str(path), 1), f"their digest is {published.digest}")
    replies: dict[str, Reply] = {}
    for number, text in enumerate(lines[1:], 2):
        if not text.strip():
            continue
        line = _parse(Line, text, path, number)
        if published is not None and line.id not in published.questions:
            raise WmsError(f"there is no question `{line.id}`", FilePlace(str(path), number), "ids are in `data`")
        if line.id in replies:
            raise WmsError(f"a second reply to `{line.id}`", FilePlace(str(path), number), "keep one")
        replies[line.id] = Reply(storable(line.reply), finish=line.finish_reason, error=line.error)
    return Submission(about, replies, hashlib.sha256(content).hexdigest())


def _parse(kind: type[Any], text: str, path: Path, number: int) -> Any:
    try:
        return kind.model_validate(json.loads(text))
    except (ValueError, RecursionError) as error:
        reason = ""
        if isinstance(error, ValidationError):
            first = error.errors()[0]
            reason = f" ({'.'.join(map(str, first['loc']))}: {first['msg']})"
        help = "the first line is about the model" if kind is About else 'a line is {"id": ..., "reply": ...}'
        raise WmsError(f"not a line of a submission{reason}", FilePlace(str(path), number), help) from None
