"""The options as shown, and their mentions in a text.

Mentions become marks: `⟦1⟧` for the option at position 1, `⟨1⟩` for a word or a lower-case letter that only counts
where an option is expected ("Answer: no", but not "there is no ball").
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from .languages import COMMON_WORDS, LABEL_NOUNS, NAMED_OBJECTS, NUMBERED_PICTURE, ORDINAL_NOUNS, ORDINAL_WORDS

LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")

#: A mark of either kind, and a list of marks: "A, B and C".
MARK = r"[⟦⟨]\d+[⟧⟩]"
#: No letter or digit touches a label; Chinese and Japanese characters may.
_FREE_BEFORE, _FREE_AFTER = r"(?<![A-Za-zÀ-ɏ0-9_&.'/+\-])", r"(?![A-Za-zÀ-ɏ0-9_&%°+]|'[a-z]|[.\-/][A-Za-z0-9])"
#: Words after a capital A that make it a label and not an article or a preposition.
_AFTER_A = (
    r"is|was|because|since|as|or|and|nor|but|matches|fits|shows|depicts|seems|looks|must|cannot|can't|does|doesn't|"
    r"isn't|would|wouldn't|could|might|correct|wrong|remains|has|appears|agrees|oder|und|ist|zeigt|passt|wäre|weil|die|das|am|"
    r"est|et|ou|montre|serait|correspond|convient|car|parce|es|y|o|muestra|sería|porque|coincide|encaja|only|too"
)


@dataclass(frozen=True)
class ShownOptions:
    """The options as shown: their words in lower case (empty for pictures), and whether their labels are numbers.

    Without labels (`labelled`), only words name an option.
    """

    words: tuple[str, ...]
    numbered: bool
    labelled: bool = True

    @classmethod
    def of(cls, options: Sequence[str | None], labels: str) -> ShownOptions:
        """Return the options for the words of each, None for a picture, and "letters", "numbers" or "words"."""
        return cls(tuple(plain(words or "") for words in options), labels == "numbers", labels != "words")

    @property
    def numeric_words(self) -> bool:
        """Whether the words of an option contain a number, so that a number need not be a position."""
        return any(re.search(r"\d", words) for words in self.words)

    def mark(self, reply: str) -> str:
        """Return a text with marks in place of all mentions."""
        text = re.sub(r"[⟦⟧⟨⟩]", " ", reply)
        if not self.numbered and not any(NUMBERED_PICTURE.search(words) for words in self.words):
            text = NUMBERED_PICTURE.sub(" ~ ", text)
        text = self._mark_words(text)
        if not self.labelled:
            return text
        text = self._mark_ordinals(text)
        # With numbers as labels, letters are steps of a list or names, unless there are no numbers.
        lettered = text if self.numbered and re.search(r"\d", reply) else self._mark_letters(text)
        return self._joined(self._mark_digits(lettered))

    def _mark_words(self, text: str) -> str:
        for place, words in sorted(enumerate(self.words), key=lambda each: -len(each[1])):
            is_label = self.numbered and words.isdecimal() and 0 < int(words) <= len(self.words)
            if words and not is_label:
                soft = words in COMMON_WORDS
                inner = r"\s+".join(re.escape(word) for word in words.split())
                pattern = rf"(?i)(?<![\w⟦⟨.])(?<!\d,)(?:(?:the|an?)\s+)?{inner}(?!\w|[.,]\d|['’]\w)"
                text = re.sub(pattern, _written(place, soft), text)
        return text

    def _mark_ordinals(self, text: str) -> str:
        for words, place in ORDINAL_WORDS:
            where = len(self.words) - 1 if place < 0 else place
            if where < len(self.words):
                text = re.sub(
                    rf"(?i)\b(?:the\s+)?(?:{words})\s*(?:{ORDINAL_NOUNS})(?![A-Za-zÀ-ɏ])", _written(where), text
                )
                text = re.sub(rf"(?i)\b(?:the\s+)?(?:{words})(?!\w)", _written(where, soft=True), text)
        return text

    def _mark_letters(self, text: str) -> str:
        last = LETTERS[: len(self.words)]
        upper, either = f"[{last}]" if last else "(?!)", f"[{last}{last.lower()}]" if last else "(?!)"

        def place(match: re.Match[str]) -> int:
            return LETTERS.index(match["label"].upper())

        text = re.sub(
            rf"(?i)(?<![A-Za-zÀ-ɏ])(?P<noun>(?:{LABEL_NOUNS})\s*[:#]?\s*)[(\[]?(?P<label>{either})(?:[)\]]|{_FREE_AFTER})"
            rf"(?!\s+{_ARTICLE_NEXT})",
            lambda match: match["noun"] + _written(place(match)),
            text,
        )
        text = re.sub(rf"(?i)\b(?:{NAMED_OBJECTS})s?\s+(?-i:{upper}){_FREE_AFTER}", " ~ ", text)
        text = re.sub(rf"[(\[{{]\s*(?P<label>{either})\s*[)\]}}]", lambda match: _written(place(match)), text)
        text = re.sub(
            rf"{_FREE_BEFORE}(?P<label>{upper}){_FREE_AFTER}(?!(?<=[AIOYE])\s+(?!(?:{_AFTER_A})\b)[a-zà-ɏ])",
            lambda match: _written(place(match)),
            text,
        )
        return re.sub(
            rf"{_FREE_BEFORE}(?P<label>[{last.lower()}]){_FREE_AFTER}" if last else "(?!)",
            lambda match: _written(place(match), soft=True),
            text,
        )

    def _mark_digits(self, text: str) -> str:
        """Mark numbers: as labels if options are numbered, else as positions where an option is expected."""
        if not self.numbered and self.numeric_words:
            return text

        if not self.numbered and len(re.findall(r"(?m)^\s*\d+[.)]\s", text)) > 1:
            text = re.sub(r"(?m)^\s*\d+[.)]\s", "", text)  # the steps of a list

        def written(match: re.Match[str]) -> str:
            place = int(match["digits"]) - 1
            line = text[text.rfind("\n", 0, match.start()) + 1 : match.start()]
            heads = not line.strip() and text[match.end() : match.end() + 1] in {".", ":", ")"}
            named = match["noun"] or match["open"] or heads
            mark = _written(place, not (self.numbered and named))
            return (match["noun"] or "") + mark if 0 <= place < len(self.words) else match[0]

        return re.sub(
            rf"(?i)(?P<noun>\b(?:{LABEL_NOUNS})\s*[:#]?\s*)?(?P<open>[(\[])?{_FREE_BEFORE}(?<![⟦⟨])(?P<digits>\d{{1,2}})"
            rf"(?![\w%°⟧⟩]|[.,]\d|[\-/]\w)(?(open)[)\]]|)",
            written,
            text,
        )

    def _joined(self, text: str) -> str:
        """Return a text in which a label with its own words is one mark: "B. the blue cube", "the blue cube (B)"."""
        same = re.compile(r"[⟦⟨](\d+)[⟧⟩](?:\s*[.:)\-–—=(]*\s*)[⟦⟨]\1[⟧⟩]\)?")
        text = re.sub(r"(?m)^(\W*)[⟦⟨](\d+)[⟧⟩]\s*[.:)]\s*[⟦⟨]\2[⟧⟩]", r"\1⟦\2⟧, ", text)
        previous = None
        while previous != text:
            previous, text = text, same.sub(r"⟦\1⟧", text)
        # "B: the red cube", where the red cube is A, chooses nothing.
        text = re.sub(rf"({MARK})\s*[:)(]\s*(?={MARK})", r"\1 or ", text)
        return re.sub(rf"(?m)^(\W*{MARK})\s*\.\s*(?={MARK}[\s.!]*$)", r"\1 or ", text)


_ARTICLE_NEXT = r"(?<=[aA]\s)(?!(?:" + _AFTER_A + r")\b)[a-zà-ɏ]"


def _written(place: int, soft: bool = False) -> str:
    return f"⟨{place}⟩" if soft else f"⟦{place}⟧"


def plain(words: str) -> str:
    """Return words in lower case, without article and surrounding punctuation."""
    return re.sub(r"^(?:the|an?)\s+", "", re.sub(r"\s+", " ", words.casefold()).strip(" .,:;!?()'[]{}"))
