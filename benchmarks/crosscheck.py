"""Processor time of `wmspec crosscheck` of the catalogue: at first, unchanged, and with one changed spec.

    python -m benchmarks.crosscheck [--sample 20] [--workers 2] [--specs FOLDER...]

Each run is a new process. Processor time counts all of its workers; the time until it ends depends on what else the
machine does. The second and third run find the results of the first.
"""

from __future__ import annotations

import argparse
import json
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from time import monotonic

from wmspec.lang.parse.files import catalogue_folders


def main() -> None:
    """Measure three runs, and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=int, default=20, help="instances of each task")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--specs", nargs="*", type=Path, default=catalogue_folders())
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        specs = Path(temporary, "specs")
        for folder in options.specs:
            shutil.copytree(folder, specs / folder.name)
        measured(options, temporary, "at first")
        measured(options, temporary, "unchanged")
        changed = [*specs.rglob("collide.wms"), *sorted(specs.rglob("*.wms"))][0]
        text, count = re.subn(r"(?m)^(task [^{]*\{)$", r"\1\n  tolerance drift 6 mm/s", changed.read_text(), count=1)
        assert count, changed
        changed.write_text(text)
        measured(options, temporary, f"{changed.name} changed")


def measured(options: argparse.Namespace, folder: str, name: str) -> None:
    """Run the command and print processor time (s), elapsed time (s) and counts."""
    command = [sys.executable, "-m", "wmspec", "crosscheck", "specs", "-n", str(options.sample)]
    command += ["-j", str(options.workers), "--cache", "cache", "--json", "out.json", "--fail-under", "0"]
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), monotonic()
    done = subprocess.run(command, cwd=folder, check=True, stdout=subprocess.PIPE, text=True)
    elapsed, after = monotonic() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    found = json.loads(Path(folder, "out.json").read_text())
    failed = sum(not instance["passes"] for instance in found["instances"])
    cached = next((line.split()[0] for line in done.stdout.splitlines() if line.endswith("from the cache")), "0")
    count = len(found["instances"])
    print(
        f"{name}: {seconds:.1f} s of processors, {elapsed:.1f} s elapsed; "
        f"{count} instances, {cached} from the cache, {failed} failed",
        flush=True,
    )


if __name__ == "__main__":
    main()
