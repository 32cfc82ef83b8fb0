"""`wmspec leaderboard`: a static page from signed receipts."""

from __future__ import annotations

from pathlib import Path

import click

_PATH = click.Path(path_type=Path)


@click.command("leaderboard")
@click.argument("receipts", type=_PATH)
@click.option("--secret", type=_PATH, required=True, metavar="FILE", help="Secret that signed the receipts.")
@click.option("--output", "-o", type=_PATH, required=True, metavar="FOLDER", help="Folder of the page.")
@click.option("--title", default="Leaderboard", show_default=True, help="Title of the page.")
def leaderboard_command(receipts: Path, secret: Path, output: Path, title: str) -> None:
    """Make a static page from the receipts in a folder. Forged or edited receipts are an error."""
    from wmspec.eval.publish.leaderboard import leaderboard
    from wmspec.eval.publish.secret import Secret

    click.echo(leaderboard(receipts, Secret.read(secret), title, output))
