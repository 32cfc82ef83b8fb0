"""The command line: `usdphysics-conformance {list,write,score,card}`."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from usdphysics_conformance import __version__
from usdphysics_conformance.case import ConformanceError
from usdphysics_conformance.cases import select_cases
from usdphysics_conformance.report import RECORD_KEYS, Record, score_card, score_text
from usdphysics_conformance.scoring import score_folder
from usdphysics_conformance.write import write_cases


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs a command and exits.

    The exit code is 0; 1 if `score` finds a number out of tolerance or a missing trace; 2 for a mistake of the user.
    """
    options = _parser().parse_args(arguments)
    run: Callable[[argparse.Namespace], int] = options.run
    try:
        code = run(options)
        sys.stdout.flush()
    except BrokenPipeError:  # as in `usdphysics-conformance list | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 141
    except ConformanceError as error:
        print(f"error: {error}", file=sys.stderr)
        code = 2
    except OSError as error:
        print(f"error: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        code = 2
    sys.exit(code)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("usdphysics-conformance", description="Score physics engines against mechanics.")
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, run: Callable[[argparse.Namespace], int], text: str) -> argparse.ArgumentParser:
        subparser = commands.add_parser(name, help=text, description=text)
        subparser.set_defaults(run=run)
        return subparser

    listed = command("list", _list, "List the cases and their criteria.")
    listed.add_argument("cases", nargs="*", metavar="CASE")
    listed.add_argument("--json", action="store_true", help="Print JSON.")
    written = command("write", _write, "Write the stages and cases.json into a folder, for an engine to execute.")
    written.add_argument("folder", type=Path, metavar="FOLDER")
    written.add_argument("cases", nargs="*", metavar="CASE")
    scored = command("score", _score, "Score the traces that engines wrote. Exit code 1 if anything fails.")
    scored.add_argument("traces", nargs="+", metavar="ENGINE=FOLDER", help="The name of an engine and its traces.")
    scored.add_argument("--case", action="append", default=[], metavar="CASE", help="Only this case; repeatable.")
    scored.add_argument("--json", action="store_true", help="Print JSON, one record a criterion and engine.")
    card = command("card", _card, "Print a score card in Markdown from what `score --json` printed.")
    card.add_argument("scores", nargs="+", type=Path, metavar="SCORES.json")
    return parser


def _list(options: argparse.Namespace) -> int:
    cases = select_cases(options.cases)
    if options.json:
        print(json.dumps([case.record() for case in cases], indent=2))
        return 0
    for case in cases:
        print(f"{case.name}  ({case.seconds:.4g} s)")
        for c in case.criteria:
            print(f"    {c.description}: {c.answer:.5g} ± {c.tolerance:.3g} {c.unit}".rstrip())
    return 0


def _write(options: argparse.Namespace) -> int:
    write_cases(options.folder, select_cases(options.cases))
    return 0


def _score(options: argparse.Namespace) -> int:
    cases = select_cases(options.case)
    engines = [_engine(text) for text in options.traces]
    scores = [score for engine, folder in engines for score in score_folder(engine, folder, cases)]
    records = [score.record() for score in scores]
    print(json.dumps(records, indent=2) if options.json else score_text(records))
    return 0 if all(score.passed for score in scores) else 1


def _engine(text: str) -> tuple[str, Path]:
    name, _, folder = text.partition("=")
    if not name or not folder:
        raise ConformanceError(f"`{text}`: expected a name and a folder, such as newton=traces")
    return name, Path(folder)


def _card(options: argparse.Namespace) -> int:
    print(score_card([record for path in options.scores for record in _records(path)]), end="")
    return 0


def _records(path: Path) -> list[Record]:
    try:
        records = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ConformanceError(f"{path}: not JSON: {error}") from None
    if not isinstance(records, list) or not all(isinstance(r, dict) and r.keys() >= RECORD_KEYS for r in records):
        raise ConformanceError(f"{path}: not what `usdphysics-conformance score --json` prints")
    return records
