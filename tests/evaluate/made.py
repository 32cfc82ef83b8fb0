"""Small datasets to ask: words, pictures, and numbers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.audit.made import Ask, make, race, roll
from wmspec.runtime.questions.kinds.numbers import NumberAnswer
from wmspec.runtime.questions.model import Number, QuestionRow

ENGINES = ("mujoco", "pybullet")


def in_words(folder: Path, count: int = 12) -> Path:
    return make(folder, "race", _drawn(race()), count, ENGINES)


def in_pictures(folder: Path, count: int = 12) -> Path:
    return make(folder, "roll", _drawn(roll()), count, ENGINES)


def _drawn(ask: Ask) -> Ask:
    """What an engine shows differs from what the other shows, in a corner."""

    def drawn(source: QuestionRow, random: np.random.Generator) -> QuestionRow:
        question = ask(source, random)
        for picture in question.context:
            picture.rgb[0, 0] = ENGINES.index(source.engine)
        return question

    return drawn


def in_numbers(folder: Path, count: int = 12) -> Path:
    """How far does it roll? Half a metre and as many centimetres as the index has."""

    def ask(source: QuestionRow, random: np.random.Generator) -> QuestionRow:
        far = Number(0.5 + source.index / 100, "m", within=0.02)
        shown = _drawn(roll())(source, random).context
        measured = NumberAnswer(far.value, 0.02)
        blank = replace(source, context=shown, options=(), answer=None)
        return replace(blank, text="How far?", value="far", number=far, evidence=measured)

    return make(folder, "roll", ask, count, ENGINES)
