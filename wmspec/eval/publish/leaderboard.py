"""A static page from receipts: models by average, with intervals, dimensions, chance, outcomes and dates."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import make_folders
from wmspec.dataset.build.files import pretty_json, with_remedies
from wmspec.dataset.build.webpage import webpage
from wmspec.eval.publish import receipt
from wmspec.eval.publish.secret import Secret
from wmspec.eval.report.frames import format_percent

Receipt = dict[str, Any]


def leaderboard(folder: Path, secret: Secret, title: str, output: Path) -> Path:
    """Write the page and copies of the receipts; returns the page's path.

    Raises WmsError if there are no receipts, or one is forged, edited or of other questions.
    """
    found: dict[Path, Receipt] = {}
    known: set[str] = set()
    for path in sorted(folder.glob("*.json")):
        content = receipt.read(path, secret)
        if content["signature"] not in known:  # a copy is no second entry
            known.add(content["signature"])
            found[path] = content
    if not found:
        raise WmsError(f"{folder} holds no receipts; `wmspec score` writes them as .json files")
    digests = {content["questions"] for content in found.values()}
    if len(digests) > 1:
        raise WmsError(f"{folder} holds receipts of {len(digests)} sets of questions; make a page for each set")
    page = output / "index.html"
    with with_remedies(output):
        make_folders(output / "receipts")
        for path, content in found.items():
            # A file may hold more than what was signed, such as a key twice.
            (output / "receipts" / path.name).write_bytes(pretty_json(content))
        page.write_text(_page(found, title), encoding="utf-8")
        if not folder.samefile(output / "receipts"):
            _withdraw(output / "receipts", {path.name for path in found}, secret)
    return page


def _withdraw(published: Path, names: set[str], secret: Secret) -> None:
    """Remove receipts that an earlier page had and this one has not. Other files stay."""
    for path in sorted(published.glob("*.json")):
        if path.name not in names:
            with suppress(WmsError):
                receipt.read(path, secret)
                path.unlink()


def _page(found: dict[Path, Receipt], title: str) -> str:
    receipts = list(found.values())
    kinds = sorted({kind for content in receipts for kind in content["scores"]}, key=_kind_order)
    return webpage(
        "wmspec.eval.publish",
        title=title,
        questions=receipts[0]["questions"],
        count=receipts[0]["count"],
        tables=[_table(kind, found) for kind in kinds],
        percent=format_percent,
    )


def _kind_order(kind: str) -> tuple[int, str]:
    return {"perception": 0, "prediction": 1}.get(kind, 2), kind


def _table(kind: str, found: dict[Path, Receipt]) -> dict[str, Any]:
    rows = [
        (path.name, content, content["scores"][kind]) for path, content in found.items() if kind in content["scores"]
    ]
    rows.sort(key=lambda row: (-(row[2]["average"]["value"] or 0), row[1]["model"]))
    dimensions = list(dict.fromkeys(name for *_, scores in rows for name in scores["dimensions"]))
    chances = [scores["chance"] for *_, scores in rows if scores["chance"] is not None]
    return {
        "kind": kind,
        "dimensions": dimensions,
        "chance": max(chances, default=None),
        "rows": [_row(name, content, scores, dimensions) for name, content, scores in rows],
    }


def _row(name: str, content: Receipt, scores: dict[str, Any], dimensions: list[str]) -> dict[str, Any]:
    lost = {key: n for key, n in content["outcomes"].items() if key != "answered" and n}
    return {
        "receipt": name,
        "model": content["model"],
        "prompt": content["prompt"],
        "date": content["date"],
        "average": scores["average"],
        "answered": scores["answered"],
        "dimensions": [scores["dimensions"].get(d) for d in dimensions],
        "lost": sum(lost.values()) / max(1, content["count"]),
        "causes": ", ".join(f"{n:,} {key}" for key, n in sorted(lost.items())),
    }
