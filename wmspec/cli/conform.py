"""`wmspec conform`: engines against mechanics, on stages of plain UsdPhysics."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmspec.cli.common import json_option, make_folder, write_text
from wmspec.core.diagnostics import WmsError

if TYPE_CHECKING:
    from wmspec.runtime.conformance.score import Score


@click.command("conform")
@click.argument("cases", nargs=-1, metavar="[CASE]...")
@click.option("--backend", "-b", default="", help="Engines: names joined by commas, all, or none.  [default: all]")
@click.option(
    "--traces", multiple=True, metavar="NAME=FOLDER", help="Score another engine, by the traces that it wrote there."
)
@click.option("--write", type=click.Path(path_type=Path), metavar="FOLDER", help="Only write the stages, for others.")
@json_option
@click.pass_context
def conform_command(
    ctx: click.Context, cases: tuple[str, ...], backend: str, traces: tuple[str, ...], write: Path | None, as_json: bool
) -> None:
    """Execute stages whose motion mechanics knows, and say how far each engine is off.

    Exit code 1 if an engine is further off than a case allows, or refuses one.
    """
    import json

    from wmspec.runtime.conformance.score import by_backend, by_traces, chosen, scores
    from wmspec.runtime.engines import registry

    wanted = chosen(cases)
    if write is not None:
        make_folder(write)
        for case in wanted:
            write_text(write / f"{case.name}.usda", case.stage)
        index = {case.name: {"stage": f"{case.name}.usda", "seconds": case.seconds, "rate": 240} for case in wanted}
        write_text(write / "cases.json", json.dumps(index, indent=2) + "\n")
        return
    engines = () if backend == "none" else registry.chosen(backend or "all")
    runners = [(name, by_backend(name)) for name in engines] + [
        (name, by_traces(Path(folder))) for name, folder in map(_named, traces)
    ]
    results = [score for name, runner in runners for score in scores(name, runner, wanted)]
    if as_json:
        click.echo(json.dumps([score.record() for score in results], indent=2))
    else:
        _print(results, [name for name, _ in runners])
    ctx.exit(0 if all(score.passed for score in results) else 1)


def _named(text: str) -> tuple[str, str]:
    name, _, folder = text.partition("=")
    if not folder:
        raise WmsError(f"--traces {text}: expected a name and a folder, such as newton=out/newton")
    return name, folder


def _print(results: list[Score], engines: list[str]) -> None:
    rows: dict[tuple[str, str], list[Score]] = {}
    for score in results:
        rows.setdefault((score.case, score.measure.what), []).append(score)
    for (case, what), row in rows.items():
        measure = row[0].measure
        click.echo(
            f"{click.style(case, bold=True)}: {what}, {measure.answer:.5g} ± {measure.tolerance:.3g} {measure.unit}"
        )
        for score in row:
            mark = click.style("ok", fg="green") if score.passed else click.style("--", fg="red")
            told = score.refusal if score.measured is None else f"{score.measured:.5g} {measure.unit}"
            click.echo(f"  {mark}  {score.engine:<9} {told}")
    for engine in engines:
        mine = [score for score in results if score.engine == engine]
        click.echo(f"{engine}: {sum(score.passed for score in mine)} of {len(mine)}")
