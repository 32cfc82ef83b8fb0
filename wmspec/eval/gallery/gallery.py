"""Writes a gallery: one self-contained page, or a folder with pictures beside the page."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from wmspec.core.safe_io import make_folders
from wmspec.dataset.build.files import with_remedies
from wmspec.dataset.build.images import data_url, decode_image, image_format
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.webpage import json_for_script, webpage
from wmspec.eval.gallery.records import NO_REPLIES, GalleryReplies, Record, about, records

#: JPEG or WebP quality of pictures inside a page, of 100.
WEBP_QUALITY = 88
#: Number of questions above which a folder stores details in separate files, and number of questions in such a file.
#: The files are loaded on demand.
MAX_INLINE_QUESTIONS, QUESTIONS_PER_FILE = 400, 50


def page(dataset: DatasetReader, per_task: int, path: Path, replies: GalleryReplies = NO_REPLIES) -> int:
    """Write one page with compressed pictures inside. Returns the number of questions.

    Raises WmsError if the file cannot be written, or if the dataset is damaged.
    """

    def inside(content: bytes) -> str:
        out = io.BytesIO()
        decode_image(content).save(out, "WEBP", quality=WEBP_QUALITY, method=4)
        return data_url("image/webp", out.getvalue())

    dataset.intact()
    with with_remedies(path):
        make_folders(path.parent)
        questions = list(records(dataset, per_task, inside, replies, partial(data_url, "video/mp4")))
        path.write_text(html(about(dataset, replies) | {"questions": questions}), encoding="utf-8")
    return len(questions)


def folder(
    dataset: DatasetReader,
    per_task: int,
    path: Path,
    replies: GalleryReplies = NO_REPLIES,
    inside: int = MAX_INLINE_QUESTIONS,
) -> int:
    """Write a folder with `index.html` and the dataset's pictures. Returns the number of questions.

    With more than `inside` questions, details are stored in separate files. Raises WmsError if it cannot be written, or
    if the dataset is damaged.
    """

    def beside(content: bytes) -> str:
        decode_image(content)
        return stored("pictures", content, image_format(content).lower())

    def film_beside(content: bytes) -> str:
        return stored("films", content, "mp4")

    def stored(kind: str, content: bytes, suffix: str) -> str:
        name = f"{hashlib.sha256(content).hexdigest()[:20]}.{suffix}"
        place = path / kind / name[:2] / name
        if not place.exists():
            make_folders(place.parent)
            place.write_bytes(content)
        return f"{kind}/{name[:2]}/{name}"

    dataset.intact()
    with with_remedies(path):
        make_folders(path)
        questions = list(_split_details(path, list(records(dataset, per_task, beside, replies, film_beside)), inside))
        path.joinpath("index.html").write_text(
            html(about(dataset, replies) | {"questions": questions}), encoding="utf-8"
        )
    return len(questions)


def _split_details(path: Path, questions: list[Record], inside: int) -> Iterator[Record]:
    """Yield the records for the page: whole, or with details moved to separate files."""
    if len(questions) <= inside:
        yield from questions
        return
    for number, begin in enumerate(range(0, len(questions), QUESTIONS_PER_FILE)):
        chunk = questions[begin : begin + QUESTIONS_PER_FILE]
        file = f"questions/{number:05d}.js"
        place = path / file
        place.parent.mkdir(exist_ok=True)
        runs = json_for_script({question["id"]: question["runs"] for question in chunk})
        place.write_text(f"wmspecQuestions({runs});\n", encoding="utf-8")
        yield from (_index_fields(question) | {"file": file} for question in chunk)


def _index_fields(question: Record) -> Record:
    """Return the fields that filters, sorting and scores use."""
    texts = list(dict.fromkeys(run["text"] for run in question["runs"]))
    return {k: v for k, v in question.items() if k != "runs"} | {"texts": texts, "true": question["runs"][0]["true"]}


def html(content: dict[str, Any]) -> str:
    """Return the page with its data."""
    return webpage("wmspec.eval.gallery", data=content, scripts_beside=True)
