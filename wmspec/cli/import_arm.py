"""`wmspec import-arm`: convert an arm for `robot NAME : arm { model: ... }`."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.cli.common import tell


@click.command("import-arm")
@click.argument("description", type=click.Path(path_type=Path))
@click.option(
    "--output", "-o", type=click.Path(path_type=Path), help="Output file.  [default: next to DESCRIPTION, as .usdc]"
)
def import_arm_command(description: Path, output: Path | None) -> None:
    """Convert an arm to USD. DESCRIPTION is a TOML file that names a URDF, MJCF or USD file and a hand.

    A spec uses the result as `robot arm : arm { model: "FILE.usdc" }`.
    """
    from wmspec.compile.robots.arm_assets import write_arm

    target = output or description.with_suffix(".usdc")
    result = write_arm(description, target)
    for feature in {d.message: f"{d.place}: {d.message}" for d in reversed(result.ignored)}.values():
        tell(f"ignored, because arms are kinematic: {feature}")
    hinges, opening = len(result.arm.low), 100 * result.arm.opening
    click.echo(
        f'{target}: {hinges} hinges and a hand that opens {opening:g} cm; robot arm : arm {{ model: "{target.name}" }}'
    )
