"""Generated pages of the site: the commands and the diagnostics. A hook of MkDocs, see `mkdocs.yml`."""

from __future__ import annotations

from collections.abc import Iterator

import click
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from wmspec.cli import main
from wmspec.lang.parse.codes import CODES
from wmspec.lang.parse.pages import page

WIDTH = 80  # characters of a line of help


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages."""
    made = {"commands": "\n".join(commands()), "diagnostics/index": "\n".join(diagnostics())}
    made |= {f"diagnostics/{code}": page(code).markdown for code in CODES}
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


def diagnostics() -> Iterator[str]:
    """Yield every code with its explanation."""
    yield "# Diagnostics\n"
    yield "The diagnostics of `wmspec check` and their remedies; `wmspec explain CODE` prints the same pages.\n"
    yield "| code | meaning |\n|---|---|"
    yield from (f"| [{code}]({code}.md) | {meaning} |" for code, meaning in CODES.items())
