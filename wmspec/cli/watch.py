"""`wmspec watch`: a spec beside its pictures, while it is being written."""

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
@click.option("--port", type=click.IntRange(0, 65535), default=8765, show_default=True, help="0: any that is free.")
@click.option("--instances", type=click.IntRange(1, 12), default=3, show_default=True, help="How many of each task.")
@click.option("--size", type=click.IntRange(32, 512), default=128, show_default=True, help="Pixels of a side.")
@click.option("--backend", "-b", default="", help="The engine that executes and draws.  [default: the first there is]")
@click.option("--open", "opens", is_flag=True, help="Open the page in a browser.")
def watch_command(spec: Path, port: int, instances: int, size: int, backend: str, opens: bool) -> None:
    """Show a spec's mistakes and a sheet of its pictures on a page, anew whenever the file is saved.

    The page is on the loopback address: only this machine sees it. Control-C ends it.
    """
    from wmspec.editor.page import PageServer
    from wmspec.editor.watch import Drawing, Watch
    from wmspec.runtime.engines.registry import chosen

    if not spec.is_file():
        raise WmsError("there is no such file", FilePlace(str(spec)), "`wmspec new NAME` writes a first spec")
    engines = chosen(backend)
    if len(engines) > 1:
        raise WmsError("a page is drawn by one engine; name one with `--backend`")
    watch = Watch(spec, Drawing(engines[0], instances, size))
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
