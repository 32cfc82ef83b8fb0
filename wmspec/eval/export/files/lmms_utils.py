"""Questions about a physical world, for lmms-eval: prompts and scores."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).parent))

from wmspec_reply import mark_row

Doc = dict[str, Any]


def doc_to_messages(doc: Doc, lmms_eval_specific_kwargs: Doc | None = None) -> list[Doc]:  # noqa: ARG001
    """Return the messages for chat models: words and pictures in order."""
    content = [
        {"type": "text", "text": part["text"]}
        if part["image"] is None
        else {"type": "image", "url": doc["images"][part["image"]].convert("RGB")}
        for part in doc["content"]
    ]
    system = [{"role": "system", "content": [{"type": "text", "text": doc["system"]}]}] if doc["system"] else []
    return [*system, {"role": "user", "content": content}]


def doc_to_visual(doc: Doc) -> list[Any]:
    """Return the pictures, for models that receive them before the words."""
    return [image.convert("RGB") for image in doc["images"]]


def doc_to_text(doc: Doc, lmms_eval_specific_kwargs: Doc | None = None) -> str:  # noqa: ARG001
    """Return the words, with `<image>` in place of each picture."""
    lines = [part["text"] if part["image"] is None else "<image>" for part in doc["content"]]
    return "\n".join([doc["system"], *lines] if doc["system"] else lines)


def doc_to_target(doc: Doc) -> str:
    """Return the position of the true option, or the true number."""
    return str(doc["answer"] if doc["answer"] is not None else doc["answer_number"])


def process_results(doc: Doc, results: list[Any]) -> dict[str, float]:
    """Return whether the reply is right, and whether it could not be parsed."""
    marked = mark_row(str(results[0]), doc)
    return {"acc": float(marked.right), "unparsed": float(not marked.parsed)}
