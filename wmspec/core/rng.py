"""Counter-based random numbers: every draw is a pure function of its key, independent of earlier draws."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from math import isqrt

_MASK = (1 << 64) - 1


def bits(*key: object) -> int:
    """Return 64 random bits of a key, equal on every machine."""
    text = "\x1f".join(str(k) for k in key)
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "big")


def uniform(*key: object) -> float:
    """Return a uniform number in [0, 1) of a key."""
    return _fraction(bits(*key))


def uniforms(*key: object) -> Callable[[object], float]:
    """Return a function of the last part of a key: `uniforms(*key)(k) == uniform(*key, k)`, quicker for many draws."""
    begun = hashlib.blake2b("\x1f".join((*map(str, key), "")).encode(), digest_size=8)

    def draw(last: object) -> float:
        whole = begun.copy()
        whole.update(str(last).encode())
        return _fraction(int.from_bytes(whole.digest(), "big"))

    return draw


def _fraction(word: int) -> float:
    """Return 64 bits as a number in [0, 1), by the 53 bits that a float holds."""
    return (word >> 11) / (1 << 53)


class Permutation:
    """A random, invertible permutation of 0..n-1 of a key, in constant memory.

    A Feistel network over `rows` times `columns` >= n with cycle walking (Black & Rogaway,
    "Ciphers with Arbitrary Finite Domains", 2002, methods 2 and 3). Round keys come from blake2b; the round
    function is the finalizer of SplitMix64 (Steele, Lea & Flood, 2014).
    """

    def __init__(self, n: int, *key: object) -> None:
        self.n = n
        self.columns = isqrt(max(n - 1, 0)) + 1
        self.rows = -(-n // self.columns)
        self._keys = tuple((bits(*key, r, "row"), bits(*key, r, "column")) for r in range(3))

    def __call__(self, i: int) -> int:
        """Return the image of `i`. Raises IndexError outside 0..n-1."""
        if not 0 <= i < self.n:
            raise IndexError(f"{i} is not in 0..{self.n - 1}")
        if self.n == 1:  # frequent: the first digit of a sample
            return 0
        while True:
            row, column = divmod(i, self.columns)
            for a, b in self._keys:
                row = (row + _mixed(column ^ a)) % self.rows
                column = (column + _mixed(row ^ b)) % self.columns
            i = row * self.columns + column
            if i < self.n:
                return i

    def inverse(self, j: int) -> int:
        """Return the preimage of `j`. Raises IndexError outside 0..n-1."""
        if not 0 <= j < self.n:
            raise IndexError(f"{j} is not in 0..{self.n - 1}")
        while True:
            row, column = divmod(j, self.columns)
            for a, b in reversed(self._keys):
                column = (column - _mixed(row ^ b)) % self.columns
                row = (row - _mixed(column ^ a)) % self.rows
            j = row * self.columns + column
            if j < self.n:
                return j


def _mixed(x: int) -> int:
    x = (x * 0x9E3779B97F4A7C15) & _MASK
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
    return x ^ (x >> 29)
