"""`wmspec things`: libraries of objects from mesh files."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.cli.common import tell
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.tables.vocabulary import COLLISIONS, MESH_UNITS


@click.group("things")
def things_command() -> None:
    """Make a library of objects from mesh files.

    See docs/guides/things.md.
    """


@things_command.command("add")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FILE|FOLDER...")
@click.option(
    "--to",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="Folder of the library.  [default: that of the files]",
)
@click.option("--units", type=click.Choice(list(MESH_UNITS)), default=None, help="Units of the meshes.  [default: m]")
@click.option(
    "--up", type=click.Choice(["x", "y", "z"]), default=None, help="Axis that points up.  [default: z; y for glTF]"
)
@click.option(
    "--collision",
    type=click.Choice(["auto", *(way for way in COLLISIONS if way != "surface")]),
    default="auto",
    show_default=True,
    help="How the meshes collide; auto: the hull if a mesh fills 90 % of it, else convex pieces.",
)
@click.option("--mass", "masses", multiple=True, metavar="NAME=MASS", help="Mass of a thing, such as mug=350g.")
@click.option("--density", type=click.FloatRange(1, 30_000), default=600.0, show_default=True, help="Of others, kg/m³.")
@click.option("--licence", default="", metavar="NAME", help="SPDX identifier of their licence, such as CC-BY-4.0.")
@click.option("--source", default="", metavar="TEXT", help="Where they come from.")
@click.option("--thumbnails/--no-thumbnails", default=True, show_default=True, help="Draw each thing.")
def add_command(
    files: tuple[Path, ...],
    to: Path | None,
    units: str | None,
    up: str | None,
    collision: str,
    masses: tuple[str, ...],
    density: float,
    licence: str,
    source: str,
    thumbnails: bool,
) -> None:
    """Register meshes as templates of FOLDER/things.wms.

    Sizes are checked. A spec beside the library begins with `use things`.
    """
    from wmspec.api.things import ThingOptions, add_things, thumbnail
    from wmspec.runtime.engines.registry import select_backends

    given = dict(map(_mass, masses))
    options = ThingOptions(units or "", up or "", collision, given, density, licence, source)
    library, things = add_things(files, options, to)
    engine = select_backends("")[0] if thumbnails else ""
    for thing in things:
        edges = " x ".join(f"{100 * edge:.3g}" for edge in thing.size)
        weight = f"{thing.mass:g} kg" if thing.mass is not None else f"{thing.density:g} kg/m³"
        click.echo(f"{thing.name}: {edges} cm, {weight}, collides as {thing.collision}")
        if thumbnails:
            try:
                thumbnail(library, thing, engine)
            except WmsError as error:
                tell(error.render())
    click.echo(library)


def _mass(text: str) -> tuple[str, float]:
    """Parse NAME=MASS into a name and kg."""
    from wmspec.lang.check.types.units import MASS, parse_quantity

    name, _, amount = text.partition("=")
    kilograms = parse_quantity(amount, "kg", MASS)
    if kilograms is None or not 0 < kilograms < 1e6:
        raise WmsError(f"--mass {text}: expected NAME=MASS, such as mug=350g")
    return name, kilograms
