"""`wmspec watch`: serve a page with previews of a spec."""

from __future__ import annotations

import threading
import webbrowser
from pathlib import Path

import click

from wmspec.cli.common import spec_argument
from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace


@click.command("watch")
@spec_argument
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8765, show_default=True, help="Port; 0 selects a free one."
)
@click.option("--instances", type=click.IntRange(1, 12), default=3, show_default=True, help="Instances per task.")
@click.option("--size", type=click.IntRange(32, 512), default=128, show_default=True, help="Picture size in pixels.")
@click.option("--backend", "-b", default="", help="Engine that executes and draws.  [default: first installed]")
@click.option("--open", "opens", is_flag=True, help="Open the page in a browser.")
def watch_command(spec: Path, port: int, instances: int, size: int, backend: str, opens: bool) -> None:
    """Serve a page with the diagnostics and pictures of a spec, updated whenever the file is saved.

    The page is on the loopback address, reachable from this machine only. Stop with Control-C.
    """
    from wmspec.editor.page import PageServer
    from wmspec.editor.watch import PreviewOptions, Watch
    from wmspec.runtime.engines.registry import select_backends

    if not spec.is_file():
        raise WmsError("no such file", FilePlace(str(spec)), "`wmspec new NAME` writes a first spec")
    engines = select_backends(backend)
    if len(engines) > 1:
        raise WmsError("expected one engine with `--backend`")
    watch = Watch(spec, PreviewOptions(engines[0], instances, size))
    server = PageServer(watch, port)
    worker = threading.Thread(target=watch.run)
    worker.start()
    click.echo(f"{spec}: {server.url}")
    if opens:
        webbrowser.open(server.url)
    try:
        server.serve_forever(poll_interval=0.2)
    except KeyboardInterrupt:
        pass
    finally:
        watch.stop()
        server.server_close()
        worker.join()
