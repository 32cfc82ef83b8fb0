"""Files that a spec names: they must exist below the spec's folder when it is checked."""

from __future__ import annotations

import ntpath
import os
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import Span
from wmspec.core.safe_io import is_within, load_image
from wmspec.lang.check.expressions.typed import Failed
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import ASSETS, FILES, STAGES
from wmspec.lang.importers.prim_names import split_prim_name
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.files import resolve_display_path

if TYPE_CHECKING:
    from wmspec.lang.check.expressions.expressions import Expressions


def resolve_path(check: Expressions, name: str, written: s.Expr, expr: ir.Expr) -> ir.Expr:
    """Return a property that names a file as a path relative to the working directory.

    A value that depends on factors keeps doing so: the folder is prepended.
    """
    named = list(possible_texts(check, written, set()))
    folders = {str(PurePosixPath(t.span.source.name).parent) for t in named}
    for text in named:
        if name == "file" and is_asset(text):
            remedy = f'write `file: "{text.value[:40]}"` in the object; it cannot depend on a factor'
            if text.value.lower().endswith(STAGES):
                remedy += f'; one mesh of it is `"{text.value[:40]}#/PRIM"`'
            check.fail("WMS210", "the file of an asset must be constant", text.span, remedy)
        check_file(check, name, text, FILES[name])
    if len(folders) > 1:
        check.fail("WMS210", "these file names stand in specs of different folders", written.span, "write them in one")
    folder = next(iter(folders), ".")
    if folder == ".":
        return expr
    if isinstance(expr, ir.Value):
        return ir.Value(value=f"{folder}/{expr.value}")
    return ir.Operation(operator="+", operands=(ir.Value(value=f"{folder}/"), expr))


def is_asset(e: s.Expr) -> bool:
    """Whether an expression names an asset file as a constant."""
    return isinstance(e, s.Text) and e.value.lower().endswith(ASSETS)


def check_file(check: Expressions, name: str, text: s.Text, endings: tuple[str, ...]) -> None:
    """Report a file that is missing, of an unreadable type, or outside the spec's folder."""
    file, prim = split_prim_name(text.value) if name == "file" else (text.value, "")
    path = PurePosixPath(file)
    if path.is_absolute() or ntpath.isabs(file) or "\\" in file or ".." in path.parts:
        check.fail("WMS210", "a file must be below the folder of the spec", text.span,
                   'put it next to the spec and write `"NAME"` or `"FOLDER/NAME"`')  # fmt: skip
    if path.suffix.lower() not in (STAGES if prim else endings):
        can = ", ".join((*endings, *(ASSETS if name == "file" else ())))
        check.fail("WMS210", f"`{name}` takes no {path.suffix or 'such'} file", text.span, f"it can be one of: {can}")
    folder = resolve_display_path(text.span.source.name).parent
    if not is_within(folder, folder / file):
        there = sorted(p.name for p in folder.glob("*") if p.suffix.lower() in endings)[:8]
        hint = f"files there: {', '.join(there)}" if there else "it is looked for beside the spec"
        if os.path.isfile(folder / file):  # noqa: PTH113  False for a name that is too long, or has a null character
            check.fail("WMS210", f"`{file}` is a link that leads out of the spec's folder", text.span, "copy it there")
        check.fail("WMS210", f"there is no file `{file}`", text.span, hint)
    if path.suffix.lower() in FILES["image"]:
        try:
            load_image(folder / file)
        except WmsError as error:
            wrong = error.diagnostics[0]
            check.fail("WMS210", f"`{file}` {wrong.message}", text.span, wrong.help)
    if prim:
        _mesh(check, text, folder, file, prim)


def _mesh(check: Expressions, text: s.Text, folder: Path, file: str, prim: str) -> None:
    """Report a mesh in a USD file that cannot be read."""
    from wmspec.lang.importers.usd_file import mesh

    read = mesh(folder / file, folder, file, prim)
    if isinstance(read, tuple):
        check.report.include(mistake.named_at(text.span) for mistake in read)
        raise Failed


def possible_texts(check: Expressions, e: s.Expr, seen: set[Span]) -> Iterator[s.Text]:
    """Yield the texts that an expression can take, through factors and `let`s."""
    match e:
        case s.Text():
            yield e
        case s.Name():
            declared = check.scope.names.get(e.id)
            if isinstance(declared, s.Factor | s.Let) and declared.span not in seen:
                seen.add(declared.span)
                yield from possible_texts(
                    check, declared.domain if isinstance(declared, s.Factor) else declared.value, seen
                )
        case s.Operation(operator="if"):
            for branch in e.operands[1:]:
                yield from possible_texts(check, branch, seen)
        case s.Items():
            for item in e.items:
                yield from possible_texts(check, item, seen)
        case s.Call():
            for argument in e.arguments:
                yield from possible_texts(check, argument.value, seen)
