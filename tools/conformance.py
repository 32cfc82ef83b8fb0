"""Write docs/benchmarks/conformance.md from the output of `wmspec conformance --json`.

python -m tools.conformance SCORES.json... [ENGINE=VERSION]...

Give versions for engines that are not installed here, scored elsewhere or by `usdphysics-conformance score --json`.
"""

from __future__ import annotations

import json
import sys
from datetime import UTC, datetime
from pathlib import Path

from usdphysics_conformance import __version__, score_card
from wmspec.runtime.engines.registry import version_of

PAGE = Path(__file__).parent.parent / "docs/benchmarks/conformance.md"

TEXT = """# Conformance: scores

This page shows how exactly physics engines execute the cases of [Conformance](../conformance.md), whose exact answers
are known. A row is a quantity that is measured in a case. The columns with names of engines hold the measured values.
A value is bold if it differs from the exact answer by more than the tolerance. A dash means that there is no value:
the engine did not execute the case, or an event that the quantity needs, such as a touch, did not occur. The last row
counts the quantities: first all of them, then those within tolerance, for each engine.

`newton` is Newton as an engine of wmspec, whose solver calls MuJoCo on the processor. `newton_alone` is Newton
without wmspec, run by the adapter in the README of the folder `conformance`.

The page was generated on {date} by `{command}`, with usdphysics-conformance {version}, {engines}.

{card}"""


def main() -> None:
    """Rewrite the page."""
    files = [argument for argument in sys.argv[1:] if "=" not in argument]
    versions = dict(argument.split("=") for argument in sys.argv[1:] if "=" in argument)
    records = [record for file in files for record in json.loads(Path(file).read_text())]
    engines = dict.fromkeys(record["engine"] for record in records)
    named = ", ".join(f"{engine} {versions.get(engine) or version_of(engine)}" for engine in engines)
    command = " ".join(["python -m tools.conformance", *sys.argv[1:]])
    text = TEXT.format(
        date=datetime.now(UTC).date(), command=command, version=__version__, engines=named, card=score_card(records)
    )
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(text)


if __name__ == "__main__":
    main()
