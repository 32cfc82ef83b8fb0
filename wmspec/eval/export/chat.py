"""Training data: chats with pictures and their answers, as TRL and LLaMA-Factory read them, split by groups."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TextIO

from wmspec.core.safe_io import make_folders
from wmspec.dataset.build.files import pretty_json
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.export.rows import Row, exported_row
from wmspec.eval.models.prompt import Prompt
from wmspec.eval.models.question import Question, questions
from wmspec.eval.models.request import Ask
from wmspec.eval.models.splits import Splits, factors_of


def write(
    dataset: DatasetReader, tasks: dict[str, list[str]], prompt: Prompt, splits: Splits, path: Callable[[str], Path]
) -> dict[str, int]:
    """Write a file of JSON lines for each split, and pictures by content; returns the number of questions by split.

    Libraries refuse empty files, so a split without questions has none. Hold-outs of the specs apply too.

    `tasks` has the ids of questions by task, `path` returns where a file goes. Raises WmsError for a prompt with
    videos, and for splits that do not fit the dataset.
    """
    splits = splits.of_dataset(dataset)
    counts = dict.fromkeys(splits.shares, 0)
    out: dict[str, TextIO] = {}
    known: set[str] = set()

    def keep(png: bytes) -> str:
        name = f"images/{hashlib.sha256(png).hexdigest()[:32]}.png"
        if name not in known:
            known.add(name)
            target = path(name)
            make_folders(target.parent)
            target.write_bytes(png)
        return name

    with ExitStack() as stack:
        for task, ids in tasks.items():
            levels = factors_of(dataset, task)
            for question in questions(dataset, ids):
                block, factors = levels[question.id]
                split = splits.of(task, block, factors)
                if split and split not in out:
                    out[split] = stack.enter_context(path(f"{split}.jsonl").open("w", encoding="utf-8"))
                if split:
                    line = _chat(question, prompt, keep) | {"seen": not splits.is_unseen(task, factors)}
                    out[split].write(json.dumps(line, ensure_ascii=False) + "\n")
                    counts[split] += 1
    path("dataset_info.json").write_bytes(pretty_json({f"wmspec_{name}": _llama_factory(name) for name in sorted(out)}))
    return counts


def _chat(question: Question, prompt: Prompt, keep: Callable[[bytes], str]) -> Row:
    row, ask = exported_row(question, prompt), Ask(question, prompt)
    # Pictures are apart and in order: TRL fills parts without a picture with them.
    content: list[Row] = [
        {"type": "text", "text": part["text"]} if part["image"] is None else {"type": "image"}
        for part in row["content"]
    ]
    plain = "\n".join(part.get("text", "<image>") for part in content)
    answer = ask.true_reply
    system = [{"role": "system", "content": prompt.system}] if prompt.system else []
    return {
        "id": question.id,
        "task": question.task,
        "group": question.group,
        "truth": ask.truth,
        "messages": [
            *({"role": m["role"], "content": [{"type": "text", "text": m["content"]}]} for m in system),
            {"role": "user", "content": content},
            {"role": "assistant", "content": [{"type": "text", "text": answer}]},
        ],
        "conversations": [*system, {"role": "user", "content": plain}, {"role": "assistant", "content": answer}],
        "images": [keep(image["bytes"]) for image in row["images"]],
    }


def _llama_factory(split: str) -> Row:
    tags = {"role_tag": "role", "content_tag": "content", "user_tag": "user", "assistant_tag": "assistant"}
    columns = {"messages": "conversations", "images": "images"}
    return {
        "file_name": f"{split}.jsonl",
        "formatting": "sharegpt",
        "columns": columns,
        "tags": tags | {"system_tag": "system"},
    }
