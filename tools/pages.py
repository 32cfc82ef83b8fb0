"""Generate pages of the site: commands, one page for each diagnostic, changelog. `mkdocs.yml` names this hook."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import click
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from wmspec.cli import main
from wmspec.lang.parse.codes import CODES
from wmspec.lang.parse.pages import page as diagnostic_page

CHANGELOG = Path(__file__).parent.parent / "CHANGELOG.md"
WIDTH = 80  # characters of a line of help


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages."""
    made = {"commands": "\n".join(commands())}
    made |= {f"diagnostics/{code}": diagnostic_page(code).markdown for code in CODES}
    made["changelog"] = CHANGELOG.read_text(encoding="utf-8")
    for name, text in made.items():
        files.append(File.generated(config, f"{name}.md", content=text + "\n"))
    return files


def commands() -> Iterator[str]:
    """Yield the help text of every command."""
    yield "# Commands\n\nMost commands are also functions of [the API](api.md)."
    whole = click.Context(main, info_name="wmspec", max_content_width=WIDTH, terminal_width=WIDTH)
    for name in main.list_commands(whole):
        command = main.get_command(whole, name)
        assert command is not None
        context = click.Context(command, whole, name, max_content_width=WIDTH, terminal_width=WIDTH)
        yield f"\n## wmspec {name}\n\n```text\n{command.get_help(context)}\n```"
        for sub in command.list_commands(context) if isinstance(command, click.Group) else ():
            part = command.get_command(context, sub)
            assert part is not None
            inner = click.Context(part, context, sub, max_content_width=WIDTH, terminal_width=WIDTH)
            yield f"\n### wmspec {name} {sub}\n\n```text\n{part.get_help(inner)}\n```"


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Link the codes of the diagnostics page to their own pages."""
    if page.file.src_uri != "reference/diagnostics.md":
        return markdown
    return re.sub(r"^\| `(WMS\d+)` \|", r"| [\1](../diagnostics/\1.md) |", markdown, flags=re.MULTILINE)
