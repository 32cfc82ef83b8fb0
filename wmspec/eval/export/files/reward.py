"""Rewards for reinforcement learning: 1 for a right reply, else 0. Replies are read as wmspec reads them.

`reward` has the signature of reward functions of TRL's GRPOTrainer. `score` marks one reply.
"""

from __future__ import annotations

from typing import Any

from wmspec_reply import mark


def score(reply: str, truth: dict[str, Any]) -> float:
    """Return the reward of a reply to the question with this `truth`, a field of each chat."""
    return float(mark(reply, **{**truth, "options": truth["options"] or []}).right)


def reward(completions: list[Any], truth: list[dict[str, Any]], **columns: Any) -> list[float]:  # noqa: ARG001
    """Return the rewards of completions: texts, or chats whose last message is the reply."""
    return [score(_text(completion), each) for completion, each in zip(completions, truth, strict=True)]


def _text(completion: Any) -> str:
    content = completion if isinstance(completion, str) else completion[-1]["content"]
    return content if isinstance(content, str) else "\n".join(part.get("text") or "" for part in content)
