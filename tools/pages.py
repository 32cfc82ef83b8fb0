"""Generate pages of the site: a page for each command, diagnostic and task; dataset columns; changelog.

`mkdocs.yml` names this hook. `python -m mkdocs` finds the modules of `tools`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import click
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

import wmspec
from tools import cards
from wmspec.api.task import Task
from wmspec.cli import main
from wmspec.dataset.build.columns import COLUMNS, FACTOR_COLUMNS, OPTIONAL
from wmspec.eval.models.results import COLUMNS as RESULTS
from wmspec.lang.parse.codes import CODES
from wmspec.lang.parse.pages import page as diagnostic_page
from wmspec.runtime.engines.registry import info, names
from wmspec.sim.scene.capability import APPROXIMATE, capability_table

CHANGELOG = Path(__file__).parent.parent / "CHANGELOG.md"
WIDTH = 80  # characters of a line of help


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """List the pages of the commands and tasks in the navigation."""
    tasks = sorted(task.name for task in _tasks())
    listed = {"commands/index.md": list(_commands()), "tasks/index.md": tasks}
    _extend(
        config.nav or [],
        {name: [f"{name.partition('/')[0]}/{page}.md" for page in pages] for name, pages in listed.items()},
    )
    return config


def _extend(nav: list[Any], listed: dict[str, list[str]]) -> None:
    """Replace entries of the navigation that name a key by sections of that page and the listed ones."""
    for entry in nav:
        for title, target in entry.items() if isinstance(entry, dict) else ():
            if isinstance(target, list):
                _extend(target, listed)
            elif target in listed:
                entry[title] = [target, *listed[target]]


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages."""
    made = {f"commands/{name}": page for name, page in _commands().items()}
    made["commands/index"] = "\n".join(_command_index())
    made |= {f"tasks/{task.name}": "\n".join(cards.card(task)) for task in _tasks()}
    made["tasks/index"] = "\n".join(cards.index(_tasks()))
    made["reference/columns"] = columns()
    made["reference/results"] = results()
    made["reference/capabilities"] = "\n".join(_capabilities())
    made |= {f"diagnostics/{code}": diagnostic_page(code).markdown for code in CODES}
    made["changelog"] = CHANGELOG.read_text(encoding="utf-8")
    for name, text in made.items():
        files.append(File.generated(config, f"{name}.md", content=text + "\n"))
    return files


@cache
def _tasks() -> tuple[Task, ...]:
    return wmspec.load_all()


@cache
def _commands() -> dict[str, str]:
    """Return the page of every command by its name: its help, and that of its subcommands."""
    whole = click.Context(main, info_name="wmspec", max_content_width=WIDTH, terminal_width=WIDTH)
    return {name: "\n".join(_command(name, whole)) for name in main.list_commands(whole)}


def _command(name: str, whole: click.Context) -> Iterator[str]:
    command = main.get_command(whole, name)
    assert command is not None
    context = click.Context(command, whole, name, max_content_width=WIDTH, terminal_width=WIDTH)
    yield f"# wmspec {name}\n\n```text\n{command.get_help(context)}\n```"
    parts = command if isinstance(command, click.Group) else click.Group()
    for sub in parts.list_commands(context):
        part = parts.get_command(context, sub)
        assert part is not None
        inner = click.Context(part, context, sub, max_content_width=WIDTH, terminal_width=WIDTH)
        yield f"\n## wmspec {name} {sub}\n\n```text\n{part.get_help(inner)}\n```"


def _command_index() -> Iterator[str]:
    yield "# Commands\n\nMost commands are also functions of [the API](../api.md).\n\n| command | does |\n|---|---|"
    whole = click.Context(main, info_name="wmspec")
    for name in _commands():
        command = main.get_command(whole, name)
        assert command is not None
        yield f"| [`wmspec {name}`]({name}.md) | {command.get_short_help_str(limit=120)} |"


def columns() -> str:
    """Return the page of the columns of a dataset."""
    return "\n".join(_columns())


def _columns() -> Iterator[str]:
    yield "# Columns of a dataset\n\nEvery row is a question. Columns with `list` hold several values.\n"
    yield from _column_table(COLUMNS)
    for group in OPTIONAL:
        yield f"\n## {group.heading}\n"
        yield from _column_table(group.columns)
    yield "\n## Factors\n\nFor every factor and nuisance `f` of the task:\n\n| column | holds |\n|---|---|"
    for prefix, meaning in FACTOR_COLUMNS.items():
        yield f"| `{prefix}.f` | {meaning} |"


def results() -> str:
    """Return the page of the columns of results."""
    head = "# Columns of results\n\nEvery row of `wmspec evaluate` and `wmspec study collect` is a reply.\n"
    return "\n".join((head, *_column_table(RESULTS)))


def _capabilities() -> Iterator[str]:
    """Yield the page of what each engine can execute, as the engines declare it."""
    engines = [info(name) for name in names()]
    yield "# Capabilities of the engines\n"
    yield "✓: executed. ≈: executed nearly. —: refused, with the reason in the last column.\n"
    yield f"| | {' | '.join(engine.title for engine in engines)} | otherwise |"
    yield "|---|" + "---|" * (len(engines) + 1)
    for capability, row in capability_table({engine.name: engine.lacks for engine in engines}):
        marks = ["≈" if why.startswith(APPROXIMATE) else "—" if why else "✓" for why in row.values()]
        yield f"| {capability} | {' | '.join(marks)} | {'; '.join(dict.fromkeys(filter(None, row.values())))} |"


def _column_table(columns: Mapping[str, tuple[object, str]]) -> Iterator[str]:
    yield "| column | type | holds |\n|---|---|---|"
    for name, (kind, meaning) in columns.items():
        words = re.sub(r"list<(?:item|element): (.*)>", r"list of \1", str(kind)).replace("|", "\\|")
        yield f"| `{name}` | {words} | {meaning} |"


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Link the codes of the diagnostics page to their own pages."""
    if page.file.src_uri != "reference/diagnostics.md":
        return markdown
    return re.sub(r"^\| `(WMS\d+)` \|", r"| [\1](../diagnostics/\1.md) |", markdown, flags=re.MULTILINE)
