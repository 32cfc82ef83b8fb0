"""The text for a video model, from a question without `film_text`."""

from __future__ import annotations

import re

_SENTENCE = re.compile(r"[^.!?]+(?:\.\d[^.!?]*)*[.!?]+\s*")
_OF_PICTURES = re.compile(r"\bpictures?\b", re.IGNORECASE)


def model_text(question: str) -> str:
    """Return the sentences of a question that neither ask nor speak of pictures."""
    sentences = [match[0].strip() for match in _SENTENCE.finditer(question)]
    return " ".join(s for s in sentences if not s.endswith("?") and not _OF_PICTURES.search(s))
