"""The page of a study: written as a static file, and rendered again by the server."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.resources import resource
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build.files import with_remedies
from wmspec.dataset.build.webpage import webpage
from wmspec.eval.study.model import PAGE_FOLDER, TEXTS_FOLDER, Item, Study
from wmspec.eval.study.wording import WORDING_FILE, default_wording, read_wording

#: Maximum size of a text (bytes).
_MAX_TEXT_BYTES = 64 << 10


def write(study: Study, folder: Path) -> None:
    """Write missing texts, and the page. Raises WmsError if they cannot be written."""
    with with_remedies(folder):
        (folder / TEXTS_FOLDER).mkdir(exist_ok=True)
        for name, text in _texts(study):
            place = folder / TEXTS_FOLDER / f"{name}.txt"
            if not place.exists():
                place.write_text(text, encoding="utf-8")
        wording = folder / TEXTS_FOLDER / WORDING_FILE
        if not wording.exists():
            wording.write_text(default_wording(), encoding="utf-8")
        (folder / PAGE_FOLDER / "index.html").write_text(html(study, folder, served=False), encoding="utf-8")


def html(study: Study, folder: Path, served: bool) -> str:
    """Return the page, which sends answers to its server or, if not `served`, saves them as a file.

    Raises WmsError if one of its texts cannot be read.
    """
    texts = {name: _read(folder / TEXTS_FOLDER / f"{name}.txt") for name, _ in _texts(study)}
    wording = read_wording(folder / TEXTS_FOLDER / WORDING_FILE).model_dump()
    return webpage(
        "wmspec.eval.study",
        language=wording["texts"]["language"],
        title=wording["texts"]["title"],
        data=study.public() | {"served": served, "texts": texts, "wording": wording},
    )


def unfinished_texts(folder: Path) -> list[Path]:
    """Return the texts that still contain bracketed placeholders."""
    return [path for path in sorted((folder / TEXTS_FOLDER).glob("*.txt")) if re.search(r"\[[^\]]{20,}\]", _read(path))]


def _texts(study: Study) -> Iterator[tuple[str, str]]:
    """Yield the names and default contents of the texts."""
    for name in ("consent", "instructions"):
        yield name, resource(f"eval/study/texts/{name}.txt").read_text(encoding="utf-8")
    firsts = {item.task: item for item in reversed(study.items) if item.kind != "check"}
    for task, first in sorted(firsts.items()):
        if not re.fullmatch(r"\w[\w.-]*", task):
            raise WmsError(f"a task cannot be called {task!r}: its instructions are a file of that name")
        yield f"task-{task}", _instructions(first)


def _instructions(item: Item) -> str:
    """Return the default instructions of a task, from its first question."""
    shown = len(item.context)
    looks = f"{shown} pictures of a scene" if shown > 1 else "a picture of a scene" if shown else "a question"
    if item.film:
        looks = "a short film of a scene" + (f", and {looks}" if shown else "")
    if item.pictures:
        does = f"choose one of {len(item.pictures)} other pictures"
    elif item.words:
        does = "choose one of the answers below"
    else:
        does = "give a number"
    numbered = " They are numbered in their order." if shown > 1 else ""
    first = " You can choose when it has ended, and play it again." if item.film else ""
    return f"In this part you see {looks}.{numbered} Read the question, then {does}.{first}\n"


def _read(path: Path) -> str:
    try:
        text = read_bytes(path)[: _MAX_TEXT_BYTES + 1]
        if len(text) > _MAX_TEXT_BYTES:
            raise WmsError(f"longer than {_MAX_TEXT_BYTES >> 10} KiB", FilePlace(str(path)), "shorten it")
        return text.decode("utf-8")
    except OSError:
        raise WmsError("is missing", FilePlace(str(path)), "`wmspec study make` writes it again") from None
    except UnicodeDecodeError:
        raise WmsError("is not UTF-8", FilePlace(str(path)), "save it as UTF-8") from None
