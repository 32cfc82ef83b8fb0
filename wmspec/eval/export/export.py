"""Writes an export: questions in the tool's format, task definition, parser of replies, and instructions."""

from __future__ import annotations

import base64
import csv
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path

from wmspec.core.safe_io import make_folders
from wmspec.dataset.build import files
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.export import chat
from wmspec.eval.export.folder import Folder
from wmspec.eval.export.rows import COLUMNS, Row, exported_rows, write
from wmspec.eval.models.prompt import Prompt
from wmspec.eval.models.question import Selection
from wmspec.eval.models.splits import DEFAULT_SPLITS, Splits
from wmspec.eval.replies import LETTERS, ORDINALS


@dataclass(frozen=True)
class Export:
    """The content of an export: selected questions, their prompt, and splits for training."""

    dataset: DatasetReader
    selection: Selection
    prompt_name: str
    prompt: Prompt
    splits: Splits = DEFAULT_SPLITS

    @cached_property
    def tasks(self) -> dict[str, list[str]]:
        """The tasks that have questions, with the questions' ids."""
        return self.selection.by_task(self.dataset)

    def rows(self, task: str) -> Iterator[Row]:
        """Yield the questions of a task, few in memory at a time."""
        return exported_rows(self.dataset, self.tasks[task], self.prompt)


def export(what: Export, tool: str, place: Path) -> int:
    """Write a folder for a tool of `WRITERS`; returns the number of questions.

    Files of an earlier export are replaced; the tool's own files stay. Raises WmsError if the folder holds something
    else or cannot be written.
    """
    folder = Folder(place)
    with files.with_remedies(place):
        folder.clear()
        count = WRITERS[tool](what, folder)
        folder.copy_reader()
        folder.mark(what.dataset, tool, prompt=what.prompt_name, prompt_hash=what.prompt.hash, questions=count)
    return count


def _tables(what: Export, folder: Folder) -> int:
    return sum(write(folder.path(f"data/{task}.parquet"), what.rows(task)) for task in what.tasks)


def _inspect(what: Export, folder: Folder) -> int:
    folder.copy("eval/export/files/inspect_task.py", "wmspec_task.py")
    folder.copy("eval/export/files/inspect.md", "README.md")
    return _tables(what, folder)


def _lmms_eval(what: Export, folder: Folder) -> int:
    """Write one file for each task, which includes a template, and a group in which every question has equal weight."""
    folder.copy("eval/export/files/lmms_utils.py", "utils.py")
    folder.copy("eval/export/files/lmms_template.yaml", "_default_template_yaml")
    folder.copy("eval/export/files/lmms-eval.md", "README.md")
    for task in what.tasks:
        data = f"dataset_kwargs:\n  data_files:\n    test: data/{task}.parquet\n"
        folder.path(f"wmspec_{task}.yaml").write_text(f"task: wmspec_{task}\n{data}include: _default_template_yaml\n")
    listed = "".join(f"  - wmspec_{task}\n" for task in what.tasks)
    metrics = "".join(
        f"  - metric: {name}\n    aggregation: mean\n    weight_by_size: true\n" for name in ("acc", "unparsed")
    )
    folder.path("wmspec.yaml").write_text(f"group: wmspec\ntask:\n{listed}aggregate_metric_list:\n{metrics}")
    return _tables(what, folder)


def _vlmevalkit(what: Export, folder: Folder) -> int:
    """Write one table, with a hash of its content in the name, because VLMEvalKit caches tables by name."""
    make_folders(folder.place)
    part, count = folder.place / "table.part", 0
    with part.open("w", newline="", encoding="utf-8") as file:
        out = csv.DictWriter(file, ["index", *_TSV], delimiter="\t", lineterminator="\n", restval="")
        out.writeheader()
        for row in chain.from_iterable(map(what.rows, what.tasks)):
            out.writerow({"index": count, **_line(row)})
            count += 1
    table = f"Wmspec_{files.digest(part)[:8]}"
    part.rename(folder.path(f"{table}.tsv"))
    folder.copy("eval/export/files/vlmeval_run.py", "wmspec_run.py")
    folder.copy("eval/export/files/vlmevalkit.md", "README.md", table=table)
    return count


_TSV = ("id", "image", "question", *LETTERS[:8], "answer", "category", "l2-category", "split", "wmspec")


def _line(row: Row) -> Row:
    """Return a question in VLMEvalKit's format, whose prompt has the pictures first; `wmspec` has the original row."""
    pictures = [base64.b64encode(image["bytes"]).decode() for image in row["images"]]
    options, pictured = row["options"], None in row["options"]
    last = f" The last {len(options)} pictures are the options." if pictured else ""
    places = [f"the {ordinal} of the last {len(options)} pictures" for ordinal in ORDINALS[: len(options)]]
    truth = {name.removeprefix("answer_"): row[name] for name in ("options", "labels", "answer", *_NUMBER)}
    requests = {"system": row["system"], "content": row["content"], "truth": truth}
    return {
        "id": row["id"],
        "image": pictures[0] if len(pictures) == 1 else str(pictures),  # VLMEvalKit parses Python lists
        "question": row["question"] + last,
        **dict(zip(LETTERS, places if pictured else options, strict=False)),
        "answer": LETTERS[row["answer"]] if options else row["answer_number"],
        "category": row["task"],
        "l2-category": row["dimension"],
        "split": "test",
        "wmspec": json.dumps(requests),
    }


_NUMBER = ("answer_number", "answer_unit", "answer_within")


def _hf(what: Export, folder: Folder) -> int:
    configs = (
        f"- config_name: {task}\n  data_files:\n  - split: test\n    path: data/{task}.parquet\n" for task in what.tasks
    )
    columns = (f"| `{name}` | {meaning} |\n" for name, (_, meaning) in COLUMNS.items())
    words = {"configs": "".join(configs), "columns": "".join(columns), "task": next(iter(what.tasks), "")}
    folder.copy("eval/export/files/hf.md", "README.md", **words)
    return _tables(what, folder)


def _chat(what: Export, folder: Folder) -> int:
    folder.copy("eval/export/files/chat.md", "README.md")
    folder.copy("eval/export/files/chat_train.py", "train.py")
    folder.copy("eval/export/files/reward.py", "reward.py")
    return sum(chat.write(what.dataset, what.tasks, what.prompt, what.splits, folder.path).values())


#: Writer by tool.
WRITERS: dict[str, Callable[[Export, Folder], int]] = {
    "inspect": _inspect,
    "lmms-eval": _lmms_eval,
    "vlmevalkit": _vlmevalkit,
    "hf": _hf,
    "chat": _chat,
}
