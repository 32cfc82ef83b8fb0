"""`wmspec lsp`: run the language server."""

from __future__ import annotations

import click

from wmspec.core.diagnostics import WmsError


@click.command("lsp")
def lsp_command() -> None:
    """Run the language server on standard input and output. Editors start it.

    Diagnostics, completion, hover, definitions, references, renaming, symbols, formatting, quick fixes, and
    `wmspec.preview`, which draws the instance at the cursor.
    """
    try:
        from wmspec.editor.server import serve
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in ("pygls", "lsprotocol"):
            raise
        raise WmsError("the language server needs pygls", help="install it with `pip install 'wmspec[lsp]'`") from None
    serve()
