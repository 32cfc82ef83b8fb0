"""The gallery on disk: one page with everything in it, or a folder with the pictures beside the page."""

from __future__ import annotations

import base64
import hashlib
import io
import json
from importlib.resources import files
from pathlib import Path

from wmspec.foreign import picture
from wmspec.gallery.records import Put, about, records
from wmspec.write.files import explained
from wmspec.write.reader import DatasetReader

#: How good the pictures inside a page are, which are compressed: of 100.
QUALITY = 88


def page(dataset: DatasetReader, per_task: int, path: Path) -> int:
    """Write one page, its pictures compressed inside it. Returns the number of questions.

    Raises WmsError if there is no such file to be written, or if the dataset is damaged.
    """

    def inside(task: str, png: bytes) -> str:  # noqa: ARG001  as `Put` has it
        out = io.BytesIO()
        picture(png, "PNG").convert("RGB").save(out, "WEBP", quality=QUALITY, method=4)
        return f"data:image/webp;base64,{base64.b64encode(out.getvalue()).decode()}"

    return _write(dataset, per_task, path, inside)


def folder(dataset: DatasetReader, per_task: int, path: Path) -> int:
    """Write a folder with `index.html` and the dataset's own pictures. Returns the number of questions.

    Raises WmsError if it cannot be written, or if the dataset is damaged.
    """

    def beside(task: str, png: bytes) -> str:
        picture(png, "PNG")
        name = f"pictures/{task}/{hashlib.sha256(png).hexdigest()[:20]}.png"
        place = path / name
        if not place.exists():
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(png)
        return name

    return _write(dataset, per_task, path / "index.html", beside)


def _write(dataset: DatasetReader, per_task: int, path: Path, put: Put) -> int:
    dataset.intact()
    with explained(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        content = about(dataset) | {"questions": list(records(dataset, per_task, put))}
        path.write_text(html(content), encoding="utf-8")
    return len(content["questions"])


def html(content: dict[str, object]) -> str:
    """The page: its template with style, data and script. No text of the data can end the element that it is in."""
    data = json.dumps(content, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    parts = {"style": _part("page.css"), "script": _part("page.js"), "data": data}
    whole = _part("page.html")
    for name, part in parts.items():
        whole = whole.replace(f"{{{{ {name} }}}}", part)
    return whole


def _part(name: str) -> str:
    return (files("wmspec.gallery") / name).read_text(encoding="utf-8")
