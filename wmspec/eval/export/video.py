"""Exports the inputs of video models: films that are shown, last pictures, and prompts; nothing of the futures."""

from __future__ import annotations

import hashlib
import json
import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError, model_validator

from wmspec.core.diagnostics import WmsError
from wmspec.core.resources import resource
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build import files
from wmspec.dataset.build.films import read_frames
from wmspec.dataset.build.images import encode_png
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.film.codec import encode_mp4
from wmspec.eval.clips.questions import FilmQuestion, selected
from wmspec.eval.export.folder import Folder
from wmspec.eval.models.prompt import FrozenModel, check_placeholders, filled
from wmspec.eval.models.question import Selection

#: The placeholders of a template: the scene and the action in words.
PLACEHOLDERS = ("film", "action")


class FilmPrompt(FrozenModel):
    """A template of prompts: `text` for a film that is continued, `text_action` for a picture."""

    text: str
    text_action: str

    @model_validator(mode="after")
    def _placeholders(self) -> FilmPrompt:
        for name, text in self:
            check_placeholders(text, PLACEHOLDERS, name)
        return self

    @property
    def hash(self) -> str:
        """Twelve hex digits that identify the content of the template."""
        return hashlib.sha256(json.dumps(self.model_dump(), sort_keys=True).encode()).hexdigest()[:12]

    def filled(self, question: FilmQuestion) -> tuple[str, str]:
        """Return the two prompts of a question."""
        words = {"film": question.text, "action": question.action_text}
        first, second = (" ".join(filled(text, words).split()) for text in (self.text, self.text_action))
        return first, second


def load_prompt(name: str) -> FilmPrompt:
    """Load a template: `film`, or the path of a .toml file. Raises WmsError if it cannot be read or is invalid."""
    file: Any = resource("eval/export/prompts/film.toml") if name in ("film", "default") else Path(name)
    if not file.is_file():
        raise WmsError(f"there is no prompt `{name}`: film, or the path of a .toml file")
    try:
        return FilmPrompt.model_validate(tomllib.loads(read_bytes(file).decode()))
    except ValidationError as error:
        first = error.errors()[0]
        message = first["msg"].removeprefix("Value error, ")
        raise WmsError(f"prompt {name}: {'.'.join(map(str, first['loc']))}: {message}") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise WmsError(f"prompt {name}: cannot be read ({error})") from None


def export_video(
    dataset: DatasetReader, selection: Selection, prompt: str, place: Path, *, every_frame: bool = False
) -> int:
    """Write the inputs of video models; returns the number of questions.

    With `every_frame`, also every frame of the context as a PNG file. Files of an earlier export are replaced. Raises
    WmsError if the dataset has no films, or the folder holds something else or cannot be written.
    """
    template, folder = load_prompt(prompt), Folder(place)
    questions = selected(dataset, selection)
    with files.with_remedies(place):
        folder.clear()
        lines = [_write(dataset, question, template, folder, every_frame) for question in questions]
        folder.table("prompts.csv", lines)
        folder.copy("eval/export/files/video.md", "README.md", example=lines[0]["clip"])
        folder.mark(
            dataset,
            "video",
            prompt=Path(prompt).stem if prompt != "default" else "film",
            prompt_hash=template.hash,
            template=template.model_dump(),
            questions=len(lines),
        )
    return len(lines)


def _write(
    dataset: DatasetReader, question: FilmQuestion, template: FilmPrompt, folder: Folder, every_frame: bool
) -> dict[str, Any]:
    """Write the pictures of a question; return its line of `prompts.csv`."""
    name = question.file_name
    frames = read_frames(dataset.folder, question.film, count=question.context)
    folder.path(f"first/{name}.png").write_bytes(encode_png(frames[-1], 6))
    folder.path(f"context/{name}.mp4").write_bytes(encode_mp4(frames, question.rate))
    for number, frame in enumerate(frames if every_frame else ()):
        folder.path(f"frames/{name}/{number:04d}.png").write_bytes(encode_png(frame))
    text, text_action = template.filled(question)
    future = question.answer_frame - question.context + 1
    return {
        "id": question.id,
        "clip": f"{name}.mp4",
        "first": f"first/{name}.png",
        "context": f"context/{name}.mp4",
        "text": text,
        "text_action": text_action,
        "seconds": f"{future / question.rate:.4g}",
        "context_seconds": f"{(question.context - 1) / question.rate:.4g}",
        "fps": question.rate,
        "frames": future,
        "context_frames": question.context,
        "width": frames.shape[2],
        "height": frames.shape[1],
    }
