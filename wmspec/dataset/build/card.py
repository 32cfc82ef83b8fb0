"""The dataset card, read by people, by the Hugging Face hub and by `load_dataset`."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence

from wmspec.compile.design.levels import Level
from wmspec.dataset.build.baselines import Baselines
from wmspec.dataset.build.columns import COLUMNS, FACTOR_COLUMNS, description
from wmspec.dataset.build.files import EXAMPLES
from wmspec.dataset.build.manifest import Summary, TaskSummary
from wmspec.dataset.build.plan import Plan, Task, row_names
from wmspec.dataset.build.rows import schema
from wmspec.dataset.build.splits import TEST
from wmspec.lang.check.ir.ir import Choices, Factor, Interval, Normal

#: The configuration that holds the questions of all tasks, with the columns that all tasks share.
ALL = "all"

#: Explanation of each rejection reason.
REASONS = {
    "ensure": "what the spec says must happen did not",
    "margin": "the answer is nearer to turning than the spec allows",
    "alike": "two options look the same",
    "unseen": "something that moves or that is asked about cannot be seen well",
    "illegible": "a person can hardly see what decides the answer",
    "overlap": "two bodies are inside one another at the start",
    "disagreement": "the engines do not agree on the answer, or one of them rejects the question",
    "invalid": "the combination of factors is impossible",
    "unstable": "the answer does not survive a nudge, or the engine gave up on the episode",
    "group": "the options are a closed set, and a sibling in the group yields no question",
    "balance": "no choice of draws was found for which the answers come equally often",
    "cause": "no candidate, or more than one, is the cause",
    "unchanged": "the change that the question imagines equals the instance itself",
    "error": "something went wrong that has no reason of its own",
    "crashed": "the engine crashed, twice, or there was not enough memory",
    "timeout": "the engine took too long, twice",
}

#: Description of each consensus setting.
CONSENSUS_TEXT: dict[str, str] = {
    "all": "Only questions on which all engines agree are kept.",
    "majority": "Only questions on which more than half of the engines agree are kept, of those engines.",
    "none": "Questions are kept whether the engines agree on them or not; the column `agreement` tells.",
}

#: The hub's size categories, each with its upper bound (rows).
_SIZES = ((10**3, "n<1K"), (10**4, "1K<n<10K"), (10**5, "10K<n<100K"), (10**6, "100K<n<1M"), (10**7, "1M<n<10M"))


def card(plan: Plan, total: Summary, scores: Mapping[str, Baselines]) -> str:
    """Return the README.md of a finished dataset: YAML metadata followed by Markdown.

    `scores` are the baselines of the tasks that have questions.
    """
    people = [
        _opening(plan, total),
        _loading(plan, total),
        _use(plan),
        _baselines(scores),
        _tasks(plan, total),
        _rejected(plan, total),
        _columns(plan),
        _citation(plan, total),
    ]
    return "\n\n".join([_front(plan, total), *people]) + "\n"


# ---------------------------------------------------------------- metadata


def _front(plan: Plan, total: Summary) -> str:
    """Return the YAML metadata."""
    size = next((name for bound, name in _SIZES if total.rows < bound), "n>10M")
    lines = ["---", "language:", "- en", "license:", *(f"- {json.dumps(name)}" for name in _licenses(plan))]
    lines += ["task_categories:", "- visual-question-answering", "- multiple-choice", "size_categories:", f"- {size}"]
    lines += ["tags:", "- wmspec", "- physics", "- world-models", "- synthetic"]
    filled = _nonempty_tasks(total)
    if filled:
        lines.append("configs:")
        lines += [
            *configuration(ALL, "*", plan.split_name),
            "  default: true",
            "  columns:",
            *(f"  - {name}" for name in COLUMNS),
        ]
    for name in filled:
        lines += configuration(name, name, plan.split_name)
    return "\n".join([*lines, "---"])


def configuration(name: str, folder: str, split: str) -> list[str]:
    """Return the YAML lines of a configuration: the files of a task, or of all tasks for `*`."""
    path = json.dumps(f"data/{folder}/{split}-*.parquet")
    return [f"- config_name: {json.dumps(name)}", "  data_files:", f"  - split: {split}", f"    path: {path}"]


def _licenses(plan: Plan) -> list[str]:
    if plan.licence:
        return [plan.licence.lower()]
    return sorted({name.lower() for t in plan.tasks for name in t.spec.licenses or ("unknown",)})


def example(task: str) -> str:
    """Return the path of a task's example picture in the dataset folder."""
    return f"{EXAMPLES}/{task}.webp"


def _nonempty_tasks(total: Summary) -> list[str]:
    """Return the names of the tasks that have questions."""
    return [t.name for t in total.tasks if sum(t.rows.values())]


# ---------------------------------------------------------------- text


def title(total: Summary) -> str:
    """Return the title of the dataset."""
    return f"{total.rows:,} questions about a physical world"


def _opening(plan: Plan, total: Summary) -> str:
    versions = ", ".join(f"{name} {number}" for name, number in sorted(plan.versions.items()))
    engines, (width, height) = ", ".join(plan.engines), plan.size
    drawn = (
        f"executed in {engines} and drawn by {plan.renderer}" if plan.renderer else f"executed and drawn in {engines}"
    )
    if plan.rows_of == "questions" and len(plan.engines) > 1:
        drawn += f"; the episodes shown are those of {plan.reference}"
    alone = "One engine executed it, so that nothing tells whether another would agree."
    return (
        f"# {title(total)}\n\n"
        f"Made by wmspec from {len(plan.tasks)} {'task' if len(plan.tasks) == 1 else 'tasks'} {drawn}; "
        f"pictures of {width} × {height} pixels, seed {plan.seed}. "
        f"{CONSENSUS_TEXT[plan.consensus] if len(plan.engines) > 1 else alone} "
        "Every answer is read off the scene and its executed episode, by a program. "
        f"The same specs, seed and versions ({versions}) give the same questions again, on the same machine to the "
        "byte."
    )


def _loading(plan: Plan, total: Summary) -> str:
    name, split = next(iter(_nonempty_tasks(total)), "TASK"), plan.split_name
    return (
        "## Loading\n\n"
        "```python\n"
        "from datasets import load_dataset\n\n"
        f'questions = load_dataset("path/to/this/folder", split="{split}")  # of all tasks\n'
        f'questions = load_dataset("path/to/this/folder", "{name}", split="{split}")  # of one, with its factors\n'
        'questions[0]["text"], questions[0]["context"]  # the pictures are PIL images\n'
        "```\n\n"
        "Or without anything but pandas: "
        f'`pandas.read_parquet("data/{name}")`; pictures are the bytes of lossless WebP. '
        "`manifest.json` has the specs' texts, all counts, every rejected question and the shards' checksums; "
        "`plan.json` says which instances were requested."
    )


def _use(plan: Plan) -> str:
    agree = ", where they agree on the answer" if plan.consensus != "none" else ""
    bodies = f"the engines named{agree}" if len(plan.engines) > 1 else "one engine"
    limits = [
        "Scenes are simple and drawn by rasterisers: a score says little about photographs.",
        f"The physics is that of rigid bodies in {bodies}.",
        "Questions are in English, from a few templates.",
        "Questions whose objects or options look the same are rejected: the rest is no fair sample of what happens.",
        "Questions of one control group (`block`) share every draw: compute intervals by group, not by question.",
    ]
    if plan.rows_of == "engines":
        limits.append("Rows of several engines are of the same episodes: they are no more questions.")
    purpose = (
        "For measuring what models that see pictures understand of a physical world, factor by factor. Not for "
        "training: a model that has seen it is not measured by it."
    )
    if plan.split is not None and plan.split.name != TEST:
        purpose = (
            f"For {'training' if plan.split.name == 'train' else 'validation during training'}: the split "
            f"`{plan.split.name}`, without the hold-outs of the specs. The split `{TEST}` measures the result."
        )
    return f"## Use and limits\n\n{purpose}\n\n" + "\n".join(f"- {limit}" for limit in limits)


def _baselines(scores: Mapping[str, Baselines]) -> str:
    head = ["task", "questions with options", "control groups", "chance", "commonest answer", "commonest place"]
    rows = [
        [name, f"{b.questions:,}", f"{b.groups:,}", *(f"{share:.1%}" for share in (b.chance, b.answer, b.place))]
        for name, b in scores.items()
        if b.questions
    ]
    consensus_text = (
        "What is right without looking: by guessing, by always saying the answer, or the place of it, that is most "
        "often true. `wmspec audit` tells whether classifiers do better without what it takes."
    )
    return f"## Baselines\n\n{consensus_text}\n\n{_table(head, rows)}"


def bibtex(plan: Plan, total: Summary) -> str:
    """Return the BibTeX entry of the dataset."""
    version = plan.versions.get("wmspec", "")
    return (
        f"@misc{{wmspec-{plan.fingerprint[:8]}, title = {{{title(total)}}}, "
        f"howpublished = {{Made with wmspec {version}}}, note = {{Fingerprint {plan.fingerprint}}}}}"
    )


def _citation(plan: Plan, total: Summary) -> str:
    licence = ", ".join(_licenses(plan))
    return (
        f"## Licence and citation\n\nLicence of the data: {licence}. The specs, in `manifest.json`, have their own.\n\n"
        f"```bibtex\n{bibtex(plan, total)}\n```"
    )


def _tasks(plan: Plan, total: Summary) -> str:
    counted = row_names(plan.rows_of, plan.engines)
    names = [f"questions, {name}" for name in counted] if plan.rows_of == "engines" else counted
    head = ["task", "dimension", "instances", *names, "rejected"]
    rows = [
        [t.name, task.spec.dimension, t.instances, *t.rows.values(), sum(t.rejected.values())]
        for task, t in zip(plan.tasks, total.tasks, strict=True)
    ]
    described = [_task(task, t) for task, t in zip(plan.tasks, total.tasks, strict=True)]
    return "\n\n".join(["## Tasks", _table(head, rows), *described])


def _task(task: Task, count: TaskSummary) -> str:
    spec = task.spec
    parts = [f"### {spec.name}", spec.description or spec.title]
    if sum(count.rows.values()):
        parts.append(f"![The pictures and options of one question of {spec.name}]({example(spec.name)})")
    if spec.factors:
        rows = [[f.name, "nuisance" if f.nuisance else "factor", _domain(f)] for f in spec.factors]
        parts.append(_table(["name", "", "values"], rows))
    rejected = ", ".join(f"{n} {reason}" for reason, n in count.rejected.items())
    facts = [("Licence of the spec", spec.license), ("Source", spec.source), ("Rejected", rejected)]
    parts += [f"{name}: {words}" for name, words in facts if words]
    return "\n\n".join(p.strip() for p in parts if p.strip())


def _domain(factor: Factor) -> str:
    match factor.domain:
        case Choices(values=values, weights=weights):
            words = ", ".join(format_level(v) for v in values)
            words += f", weighted {', '.join(map(format_level, weights))}" if weights else ""
        case Interval(low=low, high=high, logarithmic=logarithmic):
            words = f"{format_level(low)} to {format_level(high)}{', even in the logarithm' if logarithmic else ''}"
        case Normal(mean=mean, deviation=deviation):
            words = f"about {format_level(mean)}, normally with a deviation of {format_level(deviation)}"
    if factor.nuisance:
        words += ", drawn once per control group"
    return f"{words} ({factor.unit})" if factor.unit else words


def format_level(value: Level) -> str:
    """Return a factor's value in human notation."""
    if isinstance(value, tuple):
        return f"({', '.join(map(format_level, value))})"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return value if isinstance(value, str) else f"{value:.4g}"


def _rejected(plan: Plan, total: Summary) -> str:
    if not total.rejected:
        return "## Rejected\n\nNothing was rejected."
    total_questions = total.rows + sum(total.rejected.values())
    rows = [[reason, n, f"{n / total_questions:.1%}", REASONS.get(reason, "")] for reason, n in total.rejected.items()]
    counts = _table(["reason", "questions", "share", "meaning"], rows)
    each = " (each engine counted)" if plan.rows_of == "engines" and len(plan.engines) > 1 else ""
    return f"## Rejected\n\nOf {total_questions:,} questions{each}:\n\n{counts}"


def _columns(plan: Plan) -> str:
    """Return the columns of all tasks; those of factors by prefix, such as `factor.*`."""
    names = dict.fromkeys(n for task in plan.tasks for n in schema(task.spec, plan.film is not None).names)
    factors = [p for p in FACTOR_COLUMNS if any(n.startswith(f"{p}.") for n in names)]
    rows = [[f"`{n}`", description(n)] for n in names if "." not in n]
    rows += [[f"`{prefix}.*`", FACTOR_COLUMNS[prefix]] for prefix in factors]
    return "## Columns\n\n" + _table(["column", "what it holds"], rows)


def _table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    return "\n".join(f"| {' | '.join(map(_cell, line))} |" for line in (head, ["---"] * len(head), *rows))


def _cell(value: object) -> str:
    return " ".join(str(value).replace("|", "\\|").split())
