"""Which known word was meant by a misspelled one."""

from __future__ import annotations

from collections.abc import Iterable


def nearest(word: str, *groups: Iterable[str]) -> str:
    """The known word that fewest slips of the hand turn into `word`; nothing if none is close.

    Of equals it is one of an earlier group, and then one of the same letters, or that begins and ends alike. Words that
    differ in capitals or underscores alone are no slip apart; of one letter nothing else is close.
    """
    most = 1 + max(1, (len(word) + 1) // 3)
    best, merit = "", (most, 0, 0, "")
    for number, group in enumerate(groups):
        for known in group:
            if abs(len(known) - len(word)) <= merit[0]:
                apart = slips(_plain(word), _plain(known), most)
                changed = sorted(word) != sorted(known)  # not only swapped; rather left out or put in than changed
                unlike = 2 * changed + 2 * (changed and len(word) == len(known))
                unlike += (word[:1] != known[:1]) + (word[-1:] != known[-1:])
                if (
                    apart < most
                    and 2 * apart <= max(len(word), len(known))
                    and (value := (apart, number, unlike, known)) < merit
                ):
                    best, merit = known, value
    return best


def slips(a: str, b: str, most: int = 1_000) -> int:
    """How many letters to put in, leave out, change, or swap with the next turn one word into the other.

    The restricted Damerau-Levenshtein distance; counting stops at `most`.
    """
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
