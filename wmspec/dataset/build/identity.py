"""Ids of questions: keyed hashes, from which nothing about a question follows without the seed."""

from __future__ import annotations

import hashlib

#: Digits of ids: lower-case letters and digits that are not mistaken for one another (Crockford's base 32).
DIGITS = "0123456789abcdefghjkmnpqrstvwxyz"
#: Size of the hash in bytes, and number of digits between two hyphens.
_SIZE, _GROUP = 10, 4


def identity(seed: int, task: str, index: int, question: int, engine: str | None = None) -> str:
    """Return the stable id of a question, such as `collide/7k3m-9xq2-hw4d-tz8p`: 80 bits after the name of the task.

    It is equal in every dataset of this seed. `engine` is given where a question has a row for each engine.
    """
    text = "\x1f".join((task, str(index), str(question), *([engine] if engine is not None else [])))
    digest = hashlib.blake2b(text.encode(), digest_size=_SIZE, key=str(seed).encode(), person=b"wmspec id").digest()
    number = int.from_bytes(digest, "big")
    digits = "".join(DIGITS[number >> shift & 31] for shift in range(8 * _SIZE - 5, -1, -5))
    return f"{task}/{'-'.join(digits[i : i + _GROUP] for i in range(0, len(digits), _GROUP))}"
