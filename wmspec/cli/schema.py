"""`wmspec schema`: print the schema of the intermediate representation."""

from __future__ import annotations

import json

import click


@click.command("schema")
def schema_command() -> None:
    """Print the JSON schema of the output of `wmspec compile --ir`."""
    from wmspec.lang.check.ir.record import schema

    click.echo(json.dumps(schema(), indent=2))
