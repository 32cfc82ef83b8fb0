"""Exports films in the layout of Physics-IQ (Motamed et al., 2025): a benchmark with answers, for its own programs.

Take 1 is the true future, take 2 that of another engine: the physical variance that Physics-IQ has from two recordings.
Layout and names: https://github.com/google-deepmind/physics-IQ-benchmark.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build import files
from wmspec.dataset.build.films import read_frames
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.film.codec import Frames, encode_mp4
from wmspec.eval.clips.packages import opencv
from wmspec.eval.clips.pixels import motion_masks
from wmspec.eval.clips.questions import FilmQuestion, selected
from wmspec.eval.export.folder import Folder
from wmspec.eval.export.video import load_prompt
from wmspec.eval.models.question import Selection

#: Rates (Hz) of Physics-IQ, and the length (s) of what its models generate.
RATES, SECONDS = (8, 16, 24, 30), 5.0
#: Its perspectives are those of three cameras; a film has one.
_VIEW = "perspective-center"


def export_physics_iq(dataset: DatasetReader, selection: Selection, prompt: str, place: Path) -> int:
    """Write films, motion masks and descriptions in the layout of Physics-IQ; returns the number of questions.

    Files of an earlier export are replaced. Raises WmsError if films are shorter than 5 s, have another rate, or exist
    in one engine only, or if the folder holds something else or cannot be written.
    """
    template, folder = load_prompt(prompt), Folder(place)
    questions = selected(dataset, selection)
    _require_suitable(dataset, questions)
    with files.with_remedies(place):
        folder.clear()
        lines = list[dict[str, Any]]()
        for number, question in enumerate(questions, 1):
            numbers = (number, number + len(questions))
            for path, content in _files(dataset, question, numbers):
                folder.path(path).write_bytes(content)
            lines += _lines(question, numbers, template.filled(question)[0])
        folder.table("descriptions/descriptions.csv", lines)
        folder.copy("eval/export/files/physics-iq.md", "README.md", example=str(lines[0]["generated_video_name"]))
        folder.mark(dataset, "physics-iq", prompt_hash=template.hash, questions=len(lines))
    return len(lines)


def _require_suitable(dataset: DatasetReader, questions: list[FilmQuestion]) -> None:
    film = dataset.film
    assert film is not None  # `selected` requires films
    if film.rate not in RATES:
        rates = ", ".join(map(str, RATES))
        raise WmsError(f"Physics-IQ has no films with {film.rate} frames per second", help=f"it has {rates}")
    if film.seconds is None or film.seconds < SECONDS:
        help = f"make the dataset with `wmspec generate ... --film {film.rate} --film-for 5`"
        raise WmsError("films of Physics-IQ go on for 5 s after what is shown, and these may end sooner", help=help)
    alone = next((question for question in questions if not question.engines), None)
    if alone is not None:
        help = "take 2 is the film of another engine: `wmspec generate ... --backend mujoco,pybullet`"
        raise WmsError(f"{alone.id} has films in one engine only", help=help)


def _files(dataset: DatasetReader, question: FilmQuestion, numbers: tuple[int, int]) -> Iterator[tuple[str, bytes]]:
    """Yield the paths and contents of a question's files, given the numbers of its two takes."""
    rate, count = question.rate, round(SECONDS * question.rate)
    takes = list(_takes(dataset, question, count))
    context = read_frames(dataset.folder, question.film, count=question.context)
    speed = f"{rate}FPS"

    def named(kind: str, take: int) -> str:
        return f"{numbers[take - 1]:04d}_{kind}_{speed}_{_VIEW}_take-{take}_{_scenario(question)}.mp4"

    for take, future in enumerate(takes, 1):
        whole = np.concatenate([context, future])
        masks = np.repeat(motion_masks(future)[..., None], 3, axis=-1).astype(np.uint8) * 255
        yield f"full-videos/take-{take}/{speed}/{named('full-videos', take)}", encode_mp4(whole, rate)
        yield f"split-videos/testing/{speed}/{named('testing-videos', take)}", encode_mp4(future, rate)
        yield f"video-masks/real/{speed}/{named('video-masks', take)}", encode_mp4(masks, rate, 1)
    shown = encode_mp4(context, rate)
    yield f"split-videos/conditioning/{speed}/{named('conditioning-videos', 1)}", shown
    sink = io.BytesIO()
    Image.fromarray(context[-1]).save(sink, "JPEG", quality=95, subsampling=0)
    name = f"{numbers[0]:04d}_switch-frames_anyFPS_{_VIEW}_{_scenario(question)}.jpg"
    yield f"switch-frames/{name}", sink.getvalue()


def _takes(dataset: DatasetReader, question: FilmQuestion, count: int) -> Iterator[Frames]:
    """Yield the true future, and that of another engine in the same size."""
    whole = read_frames(dataset.folder, question.film)[question.context : question.context + count]
    yield whole
    # Films of other engines begin with the last picture of the context, in half the size.
    other = read_frames(dataset.folder, question.film_of(question.own, question.engines[0]))[1 : 1 + count]
    cv2, size = opencv(), (whole.shape[2], whole.shape[1])
    yield np.stack([cv2.resize(frame, size, interpolation=cv2.INTER_CUBIC) for frame in other])


def _scenario(question: FilmQuestion) -> str:
    """Return the name of the scenario, without underscores, which part the names of files: each question is one."""
    return "trimmed-" + question.file_name.replace("_", "-")


def _lines(question: FilmQuestion, numbers: tuple[int, int], text: str) -> Iterator[dict[str, Any]]:
    """Yield the descriptions of the two takes of a question."""
    for take, number in enumerate(numbers, 1):
        yield {
            "scenario": f"{number:04d}_{_VIEW}_take-{take}_{_scenario(question)}.mp4",
            "generated_video_name": f"{numbers[0]:04d}_{_VIEW}_{_scenario(question)}.mp4",
            "category": question.dimension,
            "description": text,
            "id": question.id,
        }
