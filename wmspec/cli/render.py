"""`wmspec render`: pictures of an instance."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.cli.common import instance_option, make_folder, parse_size, seed_option
from wmspec.errors import WmsError


@click.command("render")
@click.argument("source", type=click.Path(path_type=Path), metavar="SPEC|STAGE")
@click.option(
    "--backend", "-b", default="mujoco", show_default=True, help="Engines that execute: names joined by commas, or all."
)
@click.option("--renderer", "-r", default="", help="The engine that draws, if another than the one that executes.")
@instance_option
@seed_option
@click.option("--size", default="256", show_default=True, help="Pixels: 256, or 320x240.")
@click.option("--output", "-o", type=click.Path(path_type=Path), required=True, help="The folder to write to.")
def render_command(
    source: Path, backend: str, renderer: str, instance: int, seed: int, size: str, output: Path
) -> None:
    """Draw what the cameras of an instance, or of a USD stage, observe: one PNG per camera and time."""
    from PIL import Image

    from wmspec.cli.run import load_scene
    from wmspec.execute.backends import backend as load_backend
    from wmspec.execute.backends import chosen
    from wmspec.execute.studio import Studio
    from wmspec.scene.model import Shot

    width, height = parse_size(size)
    scene = load_scene(source, instance, seed)
    looks = [(o.camera, t) for o in scene.observations for t in o.times] or [(c.name, 0.0) for c in scene.cameras]
    folder = make_folder(output)
    for engine in chosen(backend):
        trace = load_backend(engine).execute(scene)
        studio = Studio(chosen(renderer)[0] if renderer else engine, width, height)
        for camera, time in looks:
            frame = studio.draw(scene, Shot(camera, trace.poses(time)))
            path = folder / f"{scene.name}-{instance:06d}-{engine}-{camera}-{time:.3f}s.png"
            try:
                Image.fromarray(frame.rgb).save(path)
            except OSError as error:
                raise WmsError(f"{path}: cannot be written: {error.strerror}") from None
            click.echo(path)
        studio.close()
