"""Questions about a physical world, for Inspect: `inspect eval wmspec_task.py --model MODEL` in this folder.

`-T task=NAME` selects one task, `-T limit=N` the first N questions of each, and `-T defaults=false` leaves temperature
and limit of tokens to the server. Every question has one outcome: answered,
unparsed, truncated, refused or error. All but the first count as wrong; `answered` is the share of the first.
"""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
from inspect_ai import Task, task
from inspect_ai.dataset import MemoryDataset, Sample
from inspect_ai.model import (
    ChatMessageSystem,
    ChatMessageUser,
    ContentImage,
    ContentText,
    GenerateConfig,
    ModelOutput,
)
from inspect_ai.scorer import (
    CORRECT,
    INCORRECT,
    NOANSWER,
    Metric,
    SampleScore,
    Score,
    Scorer,
    Target,
    accuracy,
    grouped,
    metric,
    scorer,
    stderr,
)
from inspect_ai.solver import Generate, Solver, TaskState, solver
from wmspec_reply import is_withheld, mark_row

_FOLDER = Path(__file__).parent
_TRUTH = ("options", "labels", "answer", "answer_number", "answer_unit", "answer_within")
_ABOUT = ("task", "dimension", "engine", "group")


def _sample(row: dict[str, Any]) -> Sample:
    urls = [f"data:image/png;base64,{base64.b64encode(image['bytes']).decode()}" for image in row["images"]]
    content = [
        ContentText(text=part["text"]) if part["image"] is None else ContentImage(image=urls[part["image"]])
        for part in row["content"]
    ]
    system = [ChatMessageSystem(content=row["system"])] if row["system"] else []
    truth = row["answer"] if row["answer"] is not None else row["answer_number"]
    return Sample(
        input=[*system, ChatMessageUser(content=content)],
        target=str(truth),
        id=row["id"],
        metadata={name: row[name] for name in (*_ABOUT, *_TRUTH)},
    )


@solver
def ask() -> Solver:
    """Send the question. A failed request does not end the evaluation: its outcome is `error`, as in wmspec."""

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        try:
            return await generate(state)
        except Exception as error:  # noqa: BLE001  every provider has its own
            # Inspect's message begins with the whole request.
            words = getattr(error, "provider_message", None) or str(error)[-1500:]
            message = f"{type(error).__name__}: {words}"[:2000]
            withheld = is_withheld(getattr(error, "status_code", None), message)
            state.metadata["finish" if withheld else "error"] = "content_filter" if withheld else message
            state.output = ModelOutput.from_content(str(state.model), "", error=message)
            return state

    return solve


def _finish(state: TaskState) -> str:
    """Return the reason for which the reply ended."""
    content = state.output.message.content if state.output.choices else ""
    is_refusal = not isinstance(content, str) and any(getattr(part, "refusal", None) for part in content)
    return "refusal" if is_refusal else state.metadata.get("finish", state.output.stop_reason)


@metric
def answered() -> Metric:
    """The share of questions with an answer that could be read."""

    def share(scores: list[SampleScore]) -> float:
        outcomes = [(score.score.metadata or {}).get("outcome") for score in scores]
        return outcomes.count("answered") / max(1, len(outcomes))

    return share


@scorer(metrics=[accuracy(), stderr(cluster="group"), answered(), grouped(accuracy(), "dimension")])
def right() -> Scorer:
    """Score replies as wmspec does. A question without an answer counts as wrong."""

    async def score(state: TaskState, target: Target) -> Score:  # noqa: ARG001  signature of Inspect
        metadata = state.metadata
        marked = mark_row(state.output.completion, metadata, _finish(state))
        outcome = "error" if "error" in metadata else marked.outcome
        value = (CORRECT if marked.right else INCORRECT) if outcome == "answered" else NOANSWER
        answer = marked.place if marked.place is not None else marked.number
        return Score(
            value=value,
            answer=None if answer is None else str(answer),
            explanation=state.output.error or state.output.completion,
            metadata={"outcome": outcome},
        )

    return score


@task
def wmspec(task: str = "*", limit: int | None = None, defaults: bool = True) -> Task:
    """Return the questions of all tasks, or of one."""
    samples = [
        _sample(row)
        for path in sorted(_FOLDER.glob(f"data/{task}.parquet"))
        for row in pq.read_table(path).slice(0, limit).to_pylist()
    ]
    config = GenerateConfig(temperature=0, max_tokens=1024) if defaults else GenerateConfig()
    return Task(dataset=MemoryDataset(samples, name="wmspec"), solver=ask(), scorer=right(), config=config)
