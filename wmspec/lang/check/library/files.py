"""Files that a spec names: beside the file that says so, there when the spec is checked."""

from __future__ import annotations

import ntpath
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import Span
from wmspec.core.safe_io import inside, picture
from wmspec.lang.check.expressions.typed import Failed
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import ASSETS, FILES, STAGES
from wmspec.lang.importers.prim_names import parted
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.files import located

if TYPE_CHECKING:
    from wmspec.lang.check.expressions.expressions import Expressions


def beside(check: Expressions, name: str, written: s.Expr, expr: ir.Expr) -> ir.Expr:
    """The value of a property that names a file, as a path from where wmspec was started.

    What varies stays so: the folder is put before it.
    """
    named = list(texts(check, written, set()))
    folders = {str(PurePosixPath(t.span.source.name).parent) for t in named}
    for text in named:
        if name == "file" and is_asset(text):
            remedy = f'write `file: "{text.value[:40]}"` in the object; it cannot depend on a factor'
            if text.value.lower().endswith(STAGES):
                remedy += f'; one mesh of it is `"{text.value[:40]}#/PRIM"`'
            check.fail("WMS210", "an asset is named outright", text.span, remedy)
        there(check, name, text, FILES[name])
    if len(folders) > 1:
        check.fail("WMS210", "these file names stand in specs of different folders", written.span, "say them in one")
    folder = next(iter(folders), ".")
    if folder == ".":
        return expr
    if isinstance(expr, ir.Value):
        return ir.Value(value=f"{folder}/{expr.value}")
    return ir.Operation(operator="+", operands=(ir.Value(value=f"{folder}/"), expr))


def is_asset(e: s.Expr) -> bool:
    """Whether this names the file of an asset, outright."""
    return isinstance(e, s.Text) and e.value.lower().endswith(ASSETS)


def there(check: Expressions, name: str, text: s.Text, endings: tuple[str, ...]) -> None:
    """Complain about a file that is not there, not of a sort that can be read, or not below the spec's folder."""
    file, prim = parted(text.value) if name == "file" else (text.value, "")
    path = PurePosixPath(file)
    if path.is_absolute() or ntpath.isabs(file) or "\\" in file or ".." in path.parts:
        check.fail("WMS210", "a file is named from the folder of the spec downwards", text.span,
                   'put it beside the spec and write `"NAME"` or `"FOLDER/NAME"`')  # fmt: skip
    if path.suffix.lower() not in (STAGES if prim else endings):
        can = ", ".join((*endings, *(ASSETS if name == "file" else ())))
        check.fail("WMS210", f"`{name}` takes no {path.suffix or 'such'} file", text.span, f"it can be one of: {can}")
    folder = located(text.span.source.name).parent
    if not inside(folder, folder / file):
        there = sorted(p.name for p in _neighbours(folder) if p.suffix.lower() in endings)[:8]
        hint = f"files there: {', '.join(there)}" if there else "it is looked for beside the spec"
        if _linked(folder / file):
            check.fail("WMS210", f"`{file}` is a link that leads out of the spec's folder", text.span, "copy it there")
        check.fail("WMS210", f"there is no file `{file}`", text.span, hint)
    if path.suffix.lower() in FILES["image"]:
        try:
            picture(folder / file)
        except WmsError as error:
            wrong = error.diagnostics[0]
            check.fail("WMS210", f"`{file}` {wrong.message}", text.span, wrong.help)
    if prim:
        _mesh(check, text, folder, file, prim)


def _mesh(check: Expressions, text: s.Text, folder: Path, file: str, prim: str) -> None:
    """Complain about a mesh in a USD file that cannot be read."""
    from wmspec.lang.importers.usd_file import mesh

    read = mesh(folder / file, folder, file, prim)
    if isinstance(read, tuple):
        check.report.include(mistake.named_at(text.span) for mistake in read)
        raise Failed


def _linked(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name longer than names can be, a null character
        return False


def _neighbours(folder: Path) -> Iterator[Path]:
    try:
        yield from folder.iterdir()
    except OSError:
        return


def texts(check: Expressions, e: s.Expr, seen: set[Span]) -> Iterator[s.Text]:
    """The texts that an expression can be, those of the factors and `let`s in it too."""
    match e:
        case s.Text():
            yield e
        case s.Name():
            declared = check.scope.names.get(e.id)
            if isinstance(declared, s.Factor | s.Let) and declared.span not in seen:
                seen.add(declared.span)
                yield from texts(check, declared.domain if isinstance(declared, s.Factor) else declared.value, seen)
        case s.Operation(operator="if"):
            for branch in e.operands[1:]:
                yield from texts(check, branch, seen)
        case s.Items():
            for item in e.items:
                yield from texts(check, item, seen)
        case s.Call():
            for argument in e.arguments:
                yield from texts(check, argument.value, seen)
