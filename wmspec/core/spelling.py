"""Spelling suggestions."""

from __future__ import annotations

from collections.abc import Iterable


def closest_word(word: str, *groups: Iterable[str]) -> str:
    """Return the known word with the smallest edit distance to `word`, or an empty text if none is close.

    Ties go to the earlier group, then to an anagram, then to equal first and last letters. Capitals and underscores
    do not count. One-letter words have no close words.
    """
    most = 1 + max(1, (len(word) + 1) // 3)
    best, merit = "", (most, 0, 0, "")
    for number, group in enumerate(groups):
        for known in group:
            if abs(len(known) - len(word)) <= merit[0]:
                apart = edit_distance(_plain(word), _plain(known), most)
                changed = sorted(word) != sorted(known)  # prefer swaps, then insertions and deletions, to substitutions
                unlike = 2 * changed + 2 * (changed and len(word) == len(known))
                unlike += (word[:1] != known[:1]) + (word[-1:] != known[-1:])
                if (
                    apart < most
                    and 2 * apart <= max(len(word), len(known))
                    and (value := (apart, number, unlike, known)) < merit
                ):
                    best, merit = known, value
    return best


def edit_distance(a: str, b: str, most: int = 1_000) -> int:
    """Return the restricted Damerau-Levenshtein distance of two words; counting stops at `most`."""
    before, last = [0] * (len(b) + 1), list(range(len(b) + 1))
    for i, x in enumerate(a):
        this = [i + 1]
        for j, y in enumerate(b):
            best = min(last[j] + (x != y), last[j + 1] + 1, this[j] + 1)
            if i and j and x == b[j - 1] and a[i - 1] == y:
                best = min(best, before[j - 1] + 1)
            this.append(best)
        if min(this) >= most:
            return most
        before, last = last, this
    return min(last[-1], most)


def _plain(word: str) -> str:
    return word.lower().replace("_", "").replace("-", "") or word
