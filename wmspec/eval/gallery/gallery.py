"""The gallery on disk: one page with everything in it, or a folder with the pictures beside the page."""

from __future__ import annotations

import base64
import hashlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from wmspec.core.safe_io import make_folders
from wmspec.dataset.build.files import explained
from wmspec.dataset.build.pictures import form, opened
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.webpage import encoded, webpage
from wmspec.eval.gallery.records import Record, about, records
from wmspec.eval.gallery.replies import NONE, Replies

#: How good the pictures inside a page are, which are compressed: of 100.
QUALITY = 88
#: A folder with more questions keeps most of what is known of them beside the page, in files of so many, and each is
#: loaded when one of its questions is looked at.
INSIDE, CHUNK = 400, 50


def page(dataset: DatasetReader, per_task: int, path: Path, replies: Replies = NONE) -> int:
    """Write one page, its pictures compressed inside it. Returns the number of questions.

    Raises WmsError if there is no such file to be written, or if the dataset is damaged.
    """

    def inside(task: str, content: bytes) -> str:  # noqa: ARG001  as `Put` has it
        out = io.BytesIO()
        opened(content).save(out, "WEBP", quality=QUALITY, method=4)
        return f"data:image/webp;base64,{base64.b64encode(out.getvalue()).decode()}"

    dataset.intact()
    with explained(path):
        make_folders(path.parent)
        questions = list(records(dataset, per_task, inside, replies))
        path.write_text(html(about(dataset, replies) | {"questions": questions}), encoding="utf-8")
    return len(questions)


def folder(dataset: DatasetReader, per_task: int, path: Path, replies: Replies = NONE, inside: int = INSIDE) -> int:
    """Write a folder with `index.html` and the dataset's own pictures. Returns the number of questions.

    What is known of more than `inside` questions lies beside the page. Raises WmsError if it cannot be written, or if
    the dataset is damaged.
    """

    def beside(task: str, content: bytes) -> str:  # noqa: ARG001  as `Put` has it
        name = f"{hashlib.sha256(content).hexdigest()[:20]}.{form(content).lower()}"
        opened(content)
        place = path / "pictures" / name[:2] / name
        if not place.exists():
            make_folders(place.parent)
            place.write_bytes(content)
        return f"pictures/{name[:2]}/{name}"

    dataset.intact()
    with explained(path):
        make_folders(path)
        questions = list(_parted(path, list(records(dataset, per_task, beside, replies)), inside))
        path.joinpath("index.html").write_text(
            html(about(dataset, replies) | {"questions": questions}), encoding="utf-8"
        )
    return len(questions)


def _parted(path: Path, questions: list[Record], inside: int) -> Iterator[Record]:
    """The records as the page has them: whole, or with what is looked at only in files of their own."""
    if len(questions) <= inside:
        yield from questions
        return
    for number, begin in enumerate(range(0, len(questions), CHUNK)):
        chunk = questions[begin : begin + CHUNK]
        file = f"questions/{number:05d}.js"
        place = path / file
        place.parent.mkdir(exist_ok=True)
        runs = encoded({question["id"]: question["runs"] for question in chunk})
        place.write_text(f"wmspecQuestions({runs});\n", encoding="utf-8")
        yield from (_light(question) | {"file": file} for question in chunk)


def _light(question: Record) -> Record:
    """What is filtered, sorted and scored by."""
    texts = list(dict.fromkeys(run["text"] for run in question["runs"]))
    return {k: v for k, v in question.items() if k != "runs"} | {"texts": texts, "true": question["runs"][0]["true"]}


def html(content: dict[str, Any]) -> str:
    """The page with its data."""
    return webpage("wmspec.eval.gallery", data=content, scripts_beside=True)
