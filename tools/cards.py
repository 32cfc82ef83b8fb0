"""A card for every task: what it asks, what varies, and one question at a size at which a person can answer it.

    python -m tools.cards [TASK...]     draws the questions of all tasks, or of the named ones, into docs/images/tasks

The text of the cards is made when the site is built.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from PIL import Image

import wmspec
from tools.reading import LETTERS, sheet
from wmspec.api.task import Factor, Task
from wmspec.core.rng import Permutation
from wmspec.dataset.build.format_units import format_value
from wmspec.lang.check.ir.ir import Choices, Interpolation, Question
from wmspec.lang.parse.files import catalogue_folders
from wmspec.runtime.questions.model import QuestionRow

ROOT = Path(__file__).parent.parent
PICTURES = ROOT / "docs/images/tasks"
ANSWERS = PICTURES / "answers.json"
SEED, QUALITY = 20, 80


def index(tasks: tuple[Task, ...]) -> Iterator[str]:
    """Yield the lines of the page that lists the tasks."""
    yield "# Tasks\n"
    yield f"The catalogue has {len(tasks)} tasks. Each card shows one question, and what varies in the task.\n"
    yield "| task | asks | dimension | instances | column of WM-ABench |\n|---|---|---|---:|---|"
    for task in sorted(tasks, key=lambda t: (t.dimension, t.name)):
        paper = task.paper.name if task.paper else "—"
        yield f"| [`{task.name}`]({task.name}.md) | {_summary(task)} | {task.dimension} | {len(task):,} | {paper} |"


def card(task: Task) -> Iterator[str]:
    """Yield the lines of a task's card."""
    yield f"# {task.name}\n"
    yield f"{task.spec.description or task.title}\n"
    picture = PICTURES / f"{task.name}.webp"
    if picture.exists():
        image = f"../images/tasks/{picture.name}"
        yield f"[![A question of {task.name}]({image})]({image})\n"
        yield f'??? question "Answer"\n    {json.loads(ANSWERS.read_text())[task.name]}\n'
    yield "| | |\n|---|---|"
    yield f"| dimension | {task.dimension} |"
    yield f"| instances | {len(task):,} in {task.groups:,} control groups |"
    yield f"| pictures shown | {task.images} |"
    if task.paper:
        yield f"| column of WM-ABench | {task.paper.name}, {task.paper.cases:,} cases |"
    yield f"| spec | `{Path(task.file).resolve().relative_to(ROOT.resolve())}` |\n"
    yield "## Questions\n"
    for question in task.spec.questions:
        yield f"- {f'`{question.name}`: ' if question.name else ''}{_text(question)}"
    yield "\n## Factors\n"
    yield "| factor | values | about | groups that vary it |\n|---|---|---|---:|"
    for factor in task.factors:
        yield f"| `{factor.name}` | {_values(task, factor)} | {factor.about} | {task.sample_sizes[factor.name]:,} |"
    file = Path(task.file).resolve().relative_to(ROOT.resolve())
    yield f"\n## Make it\n\n```sh\nwmspec generate {file} -o {task.name} --per-task 40\nwmspec view {task.name}\n```"


def _summary(task: Task) -> str:
    """Return the first line of the description, without its name."""
    line = (task.spec.description or task.title).partition("\n")[0]
    return (line.partition(": ")[2] or line).replace("|", "\\|")


def _text(question: Question) -> str:
    """Return the text of a question, with names for its interpolations."""
    parts = [f"*{_name(part.value)}*" if isinstance(part, Interpolation) else str(part) for part in question.text]
    return "".join(parts)


def _name(value: Any) -> str:
    if value.kind == "property":
        return f"{_name(value.owner)}'s {value.name}"
    return str(getattr(value, "name", None) or getattr(value, "value", None) or "value")


def _values(task: Task, factor: Factor) -> str:
    if factor.values is None:
        assert factor.bounds is not None
        return " to ".join(format_value(bound, factor.unit) for bound in factor.bounds)
    domain = next(f.domain for f in task.spec.factors if f.name == factor.name)
    names = domain.names if isinstance(domain, Choices) else None
    shown = list(names or (format_value(value, factor.unit) for value in factor.values))
    return ", ".join(shown if len(shown) <= 8 else [*shown[:3], "…", shown[-1]])


def draw(names: list[str]) -> None:
    """Draw one question of each task."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    answers = json.loads(ANSWERS.read_text()) if ANSWERS.exists() else {}
    for task in _tasks(names):
        question = _question(task)
        assert question.answer is not None
        options = [Image.fromarray(o.picture.rgb) if o.picture else str(o.text) for o in question.options]
        drawn = sheet(question.text, [Image.fromarray(p.rgb) for p in question.context], options)
        drawn.save(PICTURES / f"{task.name}.webp", quality=QUALITY, method=6)
        answers[task.name] = LETTERS[question.answer]
        ANSWERS.write_text(json.dumps(dict(sorted(answers.items())), indent=1) + "\n")
        print(task.name, answers[task.name])


def _tasks(names: list[str]) -> Iterator[Task]:
    """Yield the named tasks, or all, and check no other specs."""
    files = [file for folder in catalogue_folders() for file in sorted(folder.rglob("*.wms"))]
    for file in files:
        declared = re.findall(r"^task (\w+)", file.read_text(), re.MULTILINE)
        if not names or any(name.startswith(tuple(declared)) for name in names):
            yield from (task for task in wmspec.load_all(file, seed=SEED) if not names or task.name in names)


def _question(task: Task) -> QuestionRow:
    """Return the first question of the first instance that keeps it, in a random order."""
    order = Permutation(len(task), SEED, task.name)
    for number in range(len(task)):
        for question in task[order(number)].ask("mujoco"):
            if question.question == 0:
                return question
    raise SystemExit(f"{task.name} keeps no question")


if __name__ == "__main__":
    draw(sys.argv[1:])
