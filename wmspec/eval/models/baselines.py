"""Models that are none: what a score is worth is seen beside theirs. Their replies are read as any other's.

`oracle` knows the truth, `random` knows nothing. `blind` sees words and no picture, `options-only` the options and
nothing else; both have learned from all other control groups of the task which option is true how often.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from wmspec.core import rng
from wmspec.eval.models.model import Reply
from wmspec.eval.models.pictures import opened
from wmspec.eval.models.question import Question
from wmspec.eval.models.request import Ask

#: A picture is compared with others at this size (px).
_SIDE = 32


@dataclass
class _Learned:
    """Of something seen in questions, by control group: how often it was true and how often it was to choose from."""

    true: Counter[tuple[str, str]] = field(default_factory=Counter)
    offered: Counter[tuple[str, str]] = field(default_factory=Counter)
    all_true: Counter[str] = field(default_factory=Counter)
    all_offered: Counter[str] = field(default_factory=Counter)

    def learn(self, cue: str, group: str, true: bool) -> None:
        self.true[group, cue] += true
        self.offered[group, cue] += 1
        self.all_true[cue] += true
        self.all_offered[cue] += 1

    def rate(self, cue: str, group: str) -> float:
        """The share of times that it was true outside of a group, drawn towards one half where it was seldom seen."""
        true = self.all_true[cue] - self.true[group, cue]
        return (true + 1) / (self.all_offered[cue] - self.offered[group, cue] + 2)


class Baseline:
    """A baseline. `questions` are those of the dataset, their pictures not needed: what it may learn from."""

    asks = 1

    def __init__(self, name: str, questions: Iterable[Question], seed: int) -> None:
        self.identity = f"{name} {seed}"
        self._seed = seed
        self._choose = _CHOOSERS[name]
        self._learned = _Learned()
        self._numbers: dict[tuple[str, str], list[tuple[str, float]]] = {}
        for question in questions if name != "oracle" else ():
            for place, cue in enumerate(_cues(name, question)):
                self._learned.learn(cue, question.group, place == question.answer)
            if question.number is not None and not question.options:
                self._numbers.setdefault(_kind(question), []).append((question.group, question.number))

    def reply(self, ask: Ask) -> Reply:
        """The label of the option that it chooses, or a number."""
        question = ask.question
        draw = rng.uniform(self._seed, question.id, ask.permutation, ask.sample, self.identity)
        if question.options:
            which = self._choose(question, self._learned, draw)
            return Reply(ask.label(ask.order.index(which)), model_version="1")
        number = question.number if self.identity.startswith("oracle") else self._number(question, draw)
        return Reply("" if number is None else f"{number!r} {question.unit}".strip(), model_version="1")

    def _number(self, question: Question, draw: float) -> float | None:
        """The answer of another question of the kind: any of them by chance, else the median."""
        others = sorted(n for group, n in self._numbers.get(_kind(question), []) if group != question.group)
        if not others:
            return None
        return others[int(draw * len(others))] if self.identity.startswith("random") else others[len(others) // 2]


def _kind(question: Question) -> tuple[str, str]:
    return question.task, question.name


def _cues(name: str, question: Question) -> list[str]:
    """What an option is known by: its words, beside those of the question for who reads it; a picture by nothing."""
    kind, seen = "/".join(_kind(question)), question.text if name == "blind" else ""
    return [f"{kind}|{seen}|{words}" for words in question.options if words is not None]


def _oracle(question: Question, learned: _Learned, draw: float) -> int:  # noqa: ARG001
    assert question.answer is not None
    return question.answer


def _random(question: Question, learned: _Learned, draw: float) -> int:  # noqa: ARG001
    return int(draw * len(question.options))


def _likeliest(question: Question, learned: _Learned, draw: float, name: str) -> int:
    rates = [learned.rate(cue, question.group) for cue in _cues(name, question)]
    best = [place for place, rate in enumerate(rates) if rate == max(rates)]
    return best[int(draw * len(best))]


def _blind(question: Question, learned: _Learned, draw: float) -> int:
    return _likeliest(question, learned, draw, "blind") if question.in_words else _random(question, learned, draw)


def _options_only(question: Question, learned: _Learned, draw: float) -> int:
    """Of words the one that is true most often; of pictures the one that is nearest to all others."""
    if question.in_words:
        return _likeliest(question, learned, draw, "options-only")
    seen = np.stack([_small(png) for png in question.pictures])
    apart = np.abs(seen[:, None] - seen[None]).mean(axis=(2, 3, 4)).sum(axis=1)
    return int(np.argmin(apart))


def _small(png: bytes) -> NDArray[np.float64]:
    picture = opened(png).resize((_SIDE, _SIDE), Image.Resampling.BOX)
    return np.asarray(picture, dtype=np.float64)


_CHOOSERS: dict[str, Callable[[Question, _Learned, float], int]] = {
    "random": _random,
    "blind": _blind,
    "options-only": _options_only,
    "oracle": _oracle,
}

NAMES = tuple(_CHOOSERS)
