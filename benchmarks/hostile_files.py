"""Hostile datasets, traces, results and studies: no command may hang, fill the memory, show a traceback, or leak.

    python -m benchmarks.hostile_files --count 500 --pages 100

Each (`benchmarks/spoiled_files.py`) is opened by two commands of `view`, `report`, `study`, `evaluate`, `audit` and
`render`, or by the server of a study, within 120 s and 2 GB. Nothing outside its folder may be written or shown. A
sample of the resulting pages is opened in Chromium: no script of theirs may run or be stopped only by the content
security policy, and nothing outside the page's folder may be requested.
"""

from __future__ import annotations

import argparse
import random
import re
import shutil
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import perf_counter
from typing import Any
from urllib.parse import quote, unquote, urlsplit

from benchmarks.damaged import originals
from benchmarks.hostile_stages import SECRET, Outcome, print_figures, secrets, try_all
from benchmarks.spoiled_files import CANARY, Case, spoiled
from tests.study.visitor import get, post
from tests.trust.made import wmspec
from wmspec.core.diagnostics import WmsError
from wmspec.eval.study.serve import StudyServer

#: Text of /etc/passwd, which no output may contain.
FOREIGN = "root:x:0"
#: File of the output folder with the messages of the commands.
MESSAGES = "messages.txt"
Opened = Callable[[Case, Path], int]


def _command(*arguments: str) -> Opened:
    """Return what runs a command; IN is the hostile path, OUT a folder, DATASET and RESULTS are valid ones."""

    def run(case: Case, out: Path) -> int:
        places = {
            "IN": case.path,
            "OUT": out,
            "DATASET": originals() / "dataset",
            "RESULTS": originals() / "results.parquet",
        }
        split = [part.partition("/") for part in arguments]
        result = wmspec(*(f"{places.get(head, head)}{slash}{rest}" for head, slash, rest in split))
        _record(out, result.output)
        return result.exit_code

    return run


def _record(out: Path, words: str) -> None:
    with (out / MESSAGES).open("a") as file:
        file.write(words)


def _served(case: Case, out: Path) -> int:
    """Serve a study to somebody who begins, answers twice, and withdraws."""
    try:
        server = StudyServer(case.path, "127.0.0.1", 0)
    except WmsError as error:
        _record(out, error.render())
        return 2
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        port, session = server.server_address[1], "2" * 32
        for number, place in enumerate(("/", *sorted(server.files)[:4])):
            _, content = get(port, quote(place))
            (out / f"{number}{'.html' if place == '/' else ''}").write_bytes(content)
        for path, body in (
            ("/visits", {"session": session, "rater": "carl"}),
            (f"/visits/{session}/answers", {"step": 0, "text": "A", "seconds": 1.0}),
            (f"/visits/{session}/answers", {"step": 1, "text": "A", "seconds": 1.0}),
            (f"/visits/{session}/withdrawal", {}),
        ):
            status, _ = post(port, path, body)
            assert status in {200, 400, 409, 410, 503}, f"{path}: status {status}"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
    return 0


#: The commands of a kind: one of the first, then one of the second.
COMMANDS: dict[str, tuple[tuple[Opened, ...], tuple[Opened, ...]]] = {
    "dataset": (
        (_command("view", "IN", "-o", "OUT/page.html"), _command("view", "IN", "-o", "OUT/pages")),
        (
            _command("view", "IN", "-o", "OUT/sheet.png"),
            _command("study", "make", "IN", "-o", "OUT/study", "--per-task", "2"),
            _command("evaluate", "IN", "-m", "random", "-o", "OUT/r.parquet"),
            _command("report", "RESULTS", "--dataset", "IN", "-o", "OUT/report"),
            _command("audit", "IN", "-o", "OUT/audit"),
        ),
    ),
    "trace": (
        (_command("render", "IN", "-o", "OUT/pictures", "--size", "32"),),
        (_command("run", "IN", "-b", "mujoco"), _command("render", "IN", "-o", "OUT/film.gif", "--size", "32")),
    ),
    "results": (
        (
            _command("report", "IN", "-o", "OUT/report"),
            _command("view", "DATASET", "--results", "IN", "-o", "OUT/page.html"),
            _command("report", "IN", "--dataset", "DATASET", "-o", "OUT/report"),
        ),
        (
            _command("evaluate", "--rescore", "IN"),
            _command("evaluate", "DATASET", "-m", "random", "-o", "IN"),
            _command("report", "RESULTS", "--ranks", "IN"),
        ),
    ),
    "study": (
        (_served,),
        (
            _command("study", "collect", "IN", "-o", "OUT/r.parquet", "--payments", "OUT/pay.csv"),
            _command("study", "collect", "IN", "IN/ben.json", "-o", "OUT/r.parquet"),
        ),
    ),
}


def attempt(number: int, root: str) -> Outcome:
    """Make a hostile thing and open it. Exceptions other than WmsError are failures."""
    originals()
    begin = perf_counter()
    home = secrets(Path(root))
    case, out = spoiled(number, home), home / "out"
    out.mkdir()
    before = _contents(Path(root), home)
    Path("/proc/self/clear_refs").write_text("5")  # what was held while it was made does not count
    kind, words = "opened", ""
    try:
        codes = [case.chance.choice(commands)(case, out) for commands in COMMANDS[case.kind]]
        if not set(codes) <= {0, 1, 2}:
            kind = "failed"
        elif 0 not in codes:
            kind = "refused"
        words = (out / MESSAGES).read_text()
    except BaseException as error:  # noqa: BLE001  that is what is looked for
        kind, words = "failed", f"{type(error).__name__}: {error}"[:300]
    if _contents(Path(root), home) != before:
        kind, words = "failed", "written outside"
    for path in (path for path in out.rglob("*") if path.is_file() and not path.is_symlink()):
        if SECRET.encode() in (content := path.read_bytes()) or FOREIGN.encode() in content:
            kind, words = "failed", f"{path.name} shows what is outside"
        if b"Traceback (most recent" in content:
            kind, words = "failed", f"{path.name} shows a traceback"
    return Outcome(number, (case.kind, *case.changes), kind, words, perf_counter() - begin, _most_memory())


def _most_memory() -> int:
    """Return the most memory that this process has held since its mark was cleared, in bytes."""
    return int(re.findall(r"VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text())[0]) * 1024


def _contents(root: Path, home: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in root.rglob("*") if not path.is_relative_to(home) and path.is_file()}


# ---------------------------------------------------------------- pages


def complaints(browser: Any, path: Path) -> list[str]:
    """Open a page and press its buttons; return what is wrong with it."""
    from playwright.sync_api import Error

    found: list[str] = []
    context = browser.new_context(viewport={"width": 1280, "height": 1000})
    tab = context.new_page()

    def requested(request: Any) -> None:
        url = urlsplit(request.url)
        if url.scheme not in ("file", "data", "blob") or (
            url.scheme == "file" and not Path(unquote(url.path)).is_relative_to(path.parent)
        ):
            found.append(f"it requests {request.url[:200]}")

    tab.on("dialog", lambda dialog: (found.append(f"a dialog: {dialog.message}"), dialog.dismiss()))
    tab.on("pageerror", lambda error: found.append(str(error)[:300]))
    tab.on("console", lambda said: found.append(said.text[:300]) if "Failed to load" not in said.text else None)
    tab.on("request", requested)
    tab.goto(path.as_uri())
    for button in tab.locator("button:visible, summary:visible").all()[:8]:
        with suppress(Error):  # a button that another has hidden
            button.click(timeout=1_000)
    if tab.evaluate(f"typeof {CANARY}") != "undefined":
        found.append("a script of it ran")
    context.close()
    return found


def look(pages: list[Path]) -> list[str]:
    """Open pages in Chromium; return what is wrong, with the page."""
    from playwright.sync_api import sync_playwright

    from tests.browser import BROWSERS

    with sync_playwright() as started:
        place = next(filter(None, map(shutil.which, BROWSERS)))
        browser = started.chromium.launch(executable_path=place, args=["--no-sandbox"])
        wrong = [f"{page}: {each}" for page in pages for each in complaints(browser, page)]
        browser.close()
    return wrong


def main() -> None:
    """Open all, print the figures and the failures; the exit code is 1 if there are failures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--pages", type=int, default=100, help="how many pages are opened in Chromium")
    parser.add_argument("--max-time", type=float, default=36_000.0, help="seconds after which nothing is begun")
    parser.add_argument("--verbose", action="store_true", help="print every one")
    options = parser.parse_args()
    from benchmarks.hostile_files import attempt as work  # by its name, so that the process finds it

    numbers = range(options.first, options.first + options.count)
    with tempfile.TemporaryDirectory(prefix="pages") as kept:

        def keep(number: int, root: Path) -> None:
            if list((out := root / "a/b/c/out").rglob("*.html")):
                shutil.copytree(out, Path(kept) / str(number), symlinks=True)

        outcomes = try_all(work, numbers, options.max_time, options.verbose, keep)
        pages = sorted(Path(kept).rglob("*.html"))
        random.Random(options.first).shuffle(pages)  # noqa: S311
        wrong = look(pages[: options.pages]) if options.pages else []
    print(*wrong, sep="\n")
    print_figures(outcomes, "hostile things", "opened")
    print(f"{min(len(pages), options.pages)} of {len(pages)} pages in Chromium: {len(wrong)} complaints")
    sys.exit(bool(wrong) or any(outcome.kind == "failed" for outcome in outcomes))


if __name__ == "__main__":
    main()
