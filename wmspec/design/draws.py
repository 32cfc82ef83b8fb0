"""Counter-based randomness: every draw is a pure function of what it is for, never of what was drawn before."""

from __future__ import annotations

import hashlib


def bits(*key: object) -> int:
    """64 random bits that depend on the key alone, the same on every machine."""
    text = "\x1f".join(str(k) for k in key)
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "big")


def uniform(*key: object) -> float:
    """A number in [0, 1) that depends on the key alone."""
    return (bits(*key) >> 11) / (1 << 53)


def permuted(i: int, n: int, *key: object) -> int:
    """Where a random permutation of 0..n-1 sends `i`, in constant memory.

    A four-round Feistel network over the next even power of two, walked until it lands below n (Black & Rogaway,
    "Ciphers with Arbitrary Finite Domains", 2002).
    """
    if not 0 <= i < n:
        raise IndexError(f"{i} is not in 0..{n - 1}")
    half = max(1, ((n - 1).bit_length() + 1) // 2)
    mask = (1 << half) - 1
    while True:
        left, right = i >> half, i & mask
        for r in range(4):
            left, right = right, left ^ (bits(*key, r, right) & mask)
        i = left << half | right
        if i < n:
            return i
