"""Ablations: what requests leave out or change, to show what a score rests on."""

from __future__ import annotations

from typing import Literal

from wmspec.eval.models.question import Question
from wmspec.eval.models.rewording import reworded

#: `pictures` and `question` leave these out. `truth` has "none of the others" in place of the true option, `options`
#: requires words without options, `wording` has options in other words: a memorized answer is of no use there.
Ablation = Literal["pictures", "question", "truth", "options", "wording"]

Words = tuple[str | None, ...]


def option_words(question: Question, ablation: Ablation | None, none: str) -> Words:
    """Return the words of the options as a request has them, in the dataset's order, None for a picture."""
    if ablation == "truth":
        return tuple(none if place == question.answer else words for place, words in enumerate(question.options))
    if ablation == "wording":
        return tuple(reworded(words or "") or words for words in question.options)
    return question.options


def applies(question: Question, ablation: Ablation | None) -> bool:
    """Whether a question can be asked with an ablation.

    `truth` needs options, `options` needs options in words, and `wording` options that all have other words.
    """
    options = question.options
    match ablation:
        case "truth":
            return bool(options)
        case "options":
            return bool(options) and question.in_words
        case "wording":
            others = {reworded(words or "") for words in options}
            return bool(options) and "" not in others and len(others) == len(options) and not others & {*options}
    return True
