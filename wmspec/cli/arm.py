"""`wmspec arm`: an arm of one's own, for `robot NAME : arm { model: ... }`."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.cli.common import tell


@click.command("arm")
@click.argument("description", type=click.Path(path_type=Path))
@click.option("--output", "-o", type=click.Path(path_type=Path), help="The file.  [default: beside it, as .usdc]")
def arm_command(description: Path, output: Path | None) -> None:
    """Make an arm of a DESCRIPTION in TOML: a file (URDF, MJCF or USD) of links and hinges, and a hand.

    What is written is a USD file, which a spec names: `robot arm : arm { model: "FILE.usdc" }`.
    """
    from wmspec.compile.robots.arm_assets import make

    target = output or description.with_suffix(".usdc")
    made = make(description, target)
    for what in {d.message: f"{d.place}: {d.message}" for d in reversed(made.ignored)}.values():
        tell(f"left out, since an arm that moves as it is told does not need it: {what}")
    hinges, opens = len(made.arm.low), 100 * made.arm.opening
    click.echo(
        f'{target}: {hinges} hinges and a hand that opens {opens:g} cm; robot arm : arm {{ model: "{target.name}" }}'
    )
