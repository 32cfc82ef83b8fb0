"""Requests: words and pictures, determined by template, ablation and order of options."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

from wmspec.dataset.build.films import ShownFilm
from wmspec.eval.models.ablation import Ablation, Words, option_words
from wmspec.eval.models.images import VIDEO_RATE, encode_video, montage
from wmspec.eval.models.prompt import Labels, Prompt
from wmspec.eval.models.question import Question
from wmspec.eval.replies import LETTERS


@dataclass(frozen=True)
class Text:
    """Words."""

    text: str


@dataclass(frozen=True)
class Picture:
    """A picture (PNG)."""

    content: bytes


@dataclass(frozen=True)
class Clip:
    """A video (mp4)."""

    content: bytes


Part = Text | Picture | Clip


def _seconds(time: float) -> str:
    return f"{time:.2f}"


@dataclass(frozen=True)
class Request:
    """A request: the system prompt and the parts of one user turn."""

    system: str
    parts: tuple[Part, ...]

    @cached_property
    def digest(self) -> str:
        """The SHA-256 of the content."""
        content = [self.system, *(_part_text(part) for part in self.parts)]
        return hashlib.sha256(json.dumps(content).encode()).hexdigest()


def _part_text(part: Part) -> list[str]:
    match part:
        case Text(text):
            return ["text", text]
        case Picture(content) | Clip(content):
            return [type(part).__name__, hashlib.sha256(content).hexdigest()]


@dataclass(frozen=True)
class Ask:
    """One presentation of a question: its permutation, sample and ablation."""

    question: Question
    prompt: Prompt
    permutation: int = 0
    sample: int = 0
    ablation: Ablation | None = None

    @property
    def key(self) -> tuple[str, int, int]:
        """The key of this presentation in a run."""
        return self.question.id, self.permutation, self.sample

    @property
    def order(self) -> tuple[int, ...]:
        """The dataset positions of the options as shown, rotated by the permutation."""
        count = len(self.question.options)
        return tuple((place + self.permutation) % count for place in range(count))

    @property
    def words(self) -> Words:
        """The words of the options, in the dataset's order, None for a picture."""
        return option_words(self.question, self.ablation, self.prompt.texts.none_of_others)

    @property
    def labels(self) -> Labels | Literal["words"]:
        """The kind of the options' labels; "words" if the options are not shown."""
        if self.ablation == "options":
            return "words"
        return self.prompt.labels.words if self.question.in_words else self.prompt.labels.pictures

    def label(self, place: int) -> str:
        """Return the label of the option at a position (as shown)."""
        return LETTERS[place] if self.labels == "letters" else str(place + 1)

    @property
    def truth(self) -> dict[str, Any]:
        """The arguments with which `mark` scores a reply: options and answer in the order in which they are shown."""
        question = self.question
        number, unit, within = question.open_answer
        return {
            "options": [question.options[place] for place in self.order],
            "labels": self.labels,
            "answer": None if question.answer is None else self.order.index(question.answer),
            "number": number,
            "unit": unit,
            "within": within,
        }

    @property
    def true_reply(self) -> str:
        """The true answer as a model should write it: a label, or a number with its unit."""
        question = self.question
        if question.answer is not None:
            return self.label(self.order.index(question.answer))
        return f"{question.number:.4g} {question.unit}".strip()

    @cached_property
    def request(self) -> Request:
        """Return the request. Raises WmsError if a video cannot be encoded."""
        writers = {
            "pictures": self._pictures,
            "question": self._question,
            "option_words": self._option_words,
            "option_pictures": self._option_pictures,
            "instruction": self._instruction,
        }
        parts = (part for name in self.prompt.parts for part in writers[name]())
        return Request(self.prompt.system, tuple(part for part in parts if part != Text("")))

    @property
    def _film(self) -> ShownFilm | None:
        """The film, if it is shown."""
        shown = self.prompt.pictures in ("frames", "clip") and self.ablation not in ("pictures", "question")
        return self.question.film if shown else None

    def _line(self, name: str, **values: object) -> Text:
        return Text(self.prompt.texts.line(name, **values))

    def _pictures(self) -> Iterator[Part]:
        if self.ablation == "pictures":
            yield self._line("without_pictures")
            return
        shown = () if self.ablation == "question" else self.question.context
        if self.prompt.pictures == "montage":
            yield from self._sheet(shown)
        elif self.prompt.pictures == "frames":
            yield from self._labelled_with_times(shown)
        elif self.prompt.pictures == "clip" and len(shown) > 1:
            yield from self._clip(shown)
        else:
            for number, png in enumerate(shown, 1):
                yield self._line("picture", number=number)
                yield Picture(png)

    def _labelled_with_times(self, shown: tuple[bytes, ...]) -> Iterator[Part]:
        """Yield the pictures of the film, then those of other cameras; without a film, the context pictures."""
        film = self._film
        timed = list(zip(self.question.times, shown, strict=False))
        if film is not None:
            others = zip(self.question.cameras, timed, strict=True)
            timed = film.pictures(self.prompt.frames) + [each for camera, each in others if camera != film.camera]
        for number, (time, png) in enumerate(timed, 1):
            yield self._line("picture_at", number=number, time=_seconds(time))
            yield Picture(png)

    def _clip(self, shown: tuple[bytes, ...]) -> Iterator[Part]:
        """Yield the film in real time, then pictures of other cameras; without a film, the context pictures as one."""
        film = self._film
        if film is None:
            times = ", ".join(map(_seconds, self.question.times))
            yield self._line("clip", pictures=len(shown), seconds=f"{1 / VIDEO_RATE:g}", times=times)
            yield Clip(encode_video(shown))
            return
        yield self._line("clip_film", begin=_seconds(film.start), end=_seconds(film.end))
        yield Clip(film.mp4())
        pictures = zip(self.question.cameras, shown, strict=True)
        for number, png in enumerate((png for camera, png in pictures if camera != film.camera), 1):
            yield self._line("picture", number=number)
            yield Picture(png)

    def _sheet(self, shown: tuple[bytes, ...]) -> Iterator[Part]:
        options = [(self.label(place), self.question.pictures[which]) for place, which in self._pictured()]
        rows = [[(str(number), png) for number, png in enumerate(shown, 1)], options]
        labels = ", ".join(label for label, _ in options)
        if shown:
            yield self._line("montage_options" if options else "montage", pictures=len(shown), labels=labels)
        elif options:
            yield self._line("options_alone", labels=labels)
        if shown or options:
            yield Picture(montage(rows))

    def _pictured(self) -> list[tuple[int, int]]:
        """Return the places of the options that are pictures: as shown, and in the dataset."""
        return [(place, which) for place, which in enumerate(self.order) if self.words[which] is None]

    def _question(self) -> Iterator[Part]:
        if self.ablation == "question":
            yield self._line("without_question")
        elif self._film is not None:
            yield Text(self._film.text)
        else:
            yield Text(self.question.text)

    def _option_words(self) -> Iterator[Part]:
        if self.question.in_words and self.ablation != "options":
            yield Text("\n".join(self._words_of(place, which) for place, which in enumerate(self.order)))

    def _words_of(self, place: int, which: int) -> str:
        return self.prompt.texts.line("option_words", label=self.label(place), words=self.words[which])

    def _option_pictures(self) -> Iterator[Part]:
        in_montage = self.prompt.pictures == "montage" and self.ablation != "pictures"
        for place, which in enumerate(() if self.question.in_words else self.order):
            if self.words[which] is not None:
                yield Text(self._words_of(place, which))
            elif not in_montage:
                yield self._line("option_picture", label=self.label(place))
                if self.ablation != "pictures":
                    yield Picture(self.question.pictures[which])

    def _instruction(self) -> Iterator[Part]:
        if self.labels == "words":
            yield self._line("open_words")
        elif self.question.options:
            yield self._line(self.labels, count=len(self.question.options))
        elif self.question.unit:
            yield self._line("open", unit=self.question.unit)
        else:
            yield self._line("open_plain")
