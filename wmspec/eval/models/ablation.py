"""Ablations: what requests leave out or change, to show what a score rests on."""

from __future__ import annotations

import re
from typing import Literal

from wmspec.eval.models.question import Question
from wmspec.lang.check.tables.vocabulary import WORDS

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


#: Phrases with the same meaning, in English as the specs of the catalogue, the longest first. No phrase on the right is
#: one on the left.
_PHRASES = {
    "none of them": "not any of them",
    "the same number": "equally many",
    "both together": "the two at the same time",
    "equally fast": "with the same speed",
    "away from you": "further from where you are",
    "towards you": "closer to where you are",
    "to the left": "leftwards",
    "to the right": "rightwards",
    "in front of": "before",
    "less than": "below",
    "more than": "above",
    "half way": "midway",
    "heavier": "of greater mass",
    "lighter": "of smaller mass",
    "neither": "not one of the two",
    "behind": "at the back of",
    "upper": "higher",
    "right": "right-hand",
    "lower": "less high",
    "left": "left-hand",
    "near": "closer",
    "more": "a greater number of",
    "yes": "that is so",
    "far": "more distant",
    "no": "that is not so",
}
_PHRASE = re.compile(rf"\b(?:{'|'.join(map(re.escape, _PHRASES))})\b")
_NUMBERS = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
#: Units of displayed values, each with another one and its factor.
_UNITS = {"cm": ("m", 0.01), "cm/s": ("m/s", 0.01), "g": ("kg", 0.001), "s": ("ms", 1000.0), "m": ("cm", 100.0)}
_VALUE = re.compile(rf"(-?\d+(?:\.\d+)?) ({'|'.join(_UNITS)})")
_LOOKS = "|".join(sorted({*WORDS["color"], *WORDS["material"]}, key=lambda word: (-len(word), word)))
_LOOK = re.compile(rf"((?:the|an?)\s+)?({_LOOKS})(?:\s+([a-z][a-z ]*))?")


def reworded(words: str) -> str:
    """Return other words for an option; '' if no rule fits. Different options have different words.

    A number is spelled or has another unit, a colour or material follows what it describes, and phrases are replaced.
    """
    text = " ".join(words.split())
    if text.isdecimal():
        return _NUMBERS[int(text)] if int(text) < len(_NUMBERS) else ""
    if value := _VALUE.fullmatch(text):
        unit, factor = _UNITS[value[2]]
        return f"{float(value[1]) * factor:.12g} {unit}"
    if look := _LOOK.fullmatch(text):
        return f"{look[1] or ''}{look[3]} that is {look[2]}" if look[3] else f"of the kind {look[2]}"
    changed = _PHRASE.sub(lambda match: _PHRASES[match[0]], text)
    return changed if changed != text else ""
