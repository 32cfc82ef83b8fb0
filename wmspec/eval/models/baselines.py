"""Baseline models for comparison; their replies are parsed like any other.

`oracle` knows the truth, `random` guesses. `blind` sees the words and no picture, `options-only` the options and
nothing else. Both learn from the task's other control groups which options are true more often than by chance, and
guess without such options.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from wmspec.core import rng
from wmspec.eval.models.images import decode_image
from wmspec.eval.models.model import Reply
from wmspec.eval.models.question import Question
from wmspec.eval.models.request import Ask

#: The baselines.
NAMES = ("random", "blind", "options-only", "oracle")
#: Standard errors above chance from which a cue is preferred.
MIN_EVIDENCE = 2.0
#: Side of the thumbnails that are compared (px).
THUMBNAIL_SIZE = 32


@dataclass
class _CueCounts:
    """How often a cue was true and how often it was offered, by control group and in total."""

    true: Counter[tuple[str, str]] = field(default_factory=Counter)
    offered: Counter[tuple[str, str]] = field(default_factory=Counter)
    all_true: Counter[str] = field(default_factory=Counter)
    all_offered: Counter[str] = field(default_factory=Counter)

    def learn(self, cue: str, group: str, true: bool) -> None:
        self.true[group, cue] += true
        self.offered[group, cue] += 1
        self.all_true[cue] += true
        self.all_offered[cue] += 1

    def evidence(self, cue: str, group: str, chance: float) -> float:
        """Return by how many standard errors a cue is true more often outside a group than by `chance`; at least 0.

        0 below `MIN_EVIDENCE`. In a balanced set the other groups lack what the group has, so that a preference without
        evidence would choose against the truth more often than chance.
        """
        true = self.all_true[cue] - self.true[group, cue]
        offered = self.all_offered[cue] - self.offered[group, cue]
        if not offered:
            return 0.0
        errors = (true - chance * offered) / math.sqrt(offered * chance * (1 - chance))
        return errors if errors >= MIN_EVIDENCE else 0.0


class Baseline:
    """A baseline. It learns from `questions`, those of the dataset; their pictures are not needed."""

    asks = 1
    notes = ()

    def __init__(self, name: str, questions: Iterable[Question], seed: int) -> None:
        self.identity = f"{name} {seed}"
        self._seed = seed
        self._name = name
        self._learned = _CueCounts()
        self._numbers: dict[tuple[str, str], list[tuple[str, float]]] = {}
        for question in questions if name != "oracle" else ():
            for place, cue in enumerate(_cues(name, question)):
                self._learned.learn(cue, question.group, place == question.answer)
            if question.number is not None and not question.options:
                self._numbers.setdefault(_question_kind(question), []).append((question.group, question.number))

    def reply(self, ask: Ask) -> Reply:
        """Return the label of the chosen option, or a number."""
        question = ask.question
        draw = rng.uniform(self._seed, question.id, ask.permutation, ask.sample, self.identity)
        if question.options:
            which = self._choose(question, draw)
            return Reply(ask.label(ask.order.index(which)), model_version="1")
        number = question.number if self._name == "oracle" else self._number(question, draw)
        return Reply("" if number is None else f"{number!r} {question.unit}".strip(), model_version="1")

    def _choose(self, question: Question, draw: float) -> int:
        """Return the true option, a random one, the one with the likeliest words, or the picture nearest the others."""
        if self._name == "oracle":
            assert question.answer is not None
            return question.answer
        count = len(question.options)
        if self._name == "random" or (self._name == "blind" and not question.in_words):
            return int(draw * count)
        if question.in_words:
            cues = _cues(self._name, question)
            found = [self._learned.evidence(cue, question.group, 1 / count) if count > 1 else 0.0 for cue in cues]
            best = [place for place, evidence in enumerate(found) if evidence == max(found)]
            return best[int(draw * len(best))]
        seen = np.stack([_thumbnail(png) for png in question.pictures])
        apart = np.abs(seen[:, None] - seen[None]).mean(axis=(2, 3, 4)).sum(axis=1)
        return int(np.argmin(apart))

    def _number(self, question: Question, draw: float) -> float | None:
        """Return the number of another question of the same kind: a random one, or the median."""
        others = sorted(n for group, n in self._numbers.get(_question_kind(question), []) if group != question.group)
        if not others:
            return None
        return others[int(draw * len(others))] if self._name == "random" else others[len(others) // 2]


def _question_kind(question: Question) -> tuple[str, str]:
    return question.task, question.name


def _cues(name: str, question: Question) -> list[str]:
    """Return the cue of each option: its words, with the question's for `blind`; an empty one for a picture."""
    kind, seen = "/".join(_question_kind(question)), question.text if name == "blind" else ""
    return [f"{kind}|{seen}|{words}" for words in question.options if words is not None]


def _thumbnail(png: bytes) -> NDArray[np.float64]:
    picture = decode_image(png).resize((THUMBNAIL_SIZE, THUMBNAIL_SIZE), Image.Resampling.BOX)
    return np.asarray(picture, dtype=np.float64)
