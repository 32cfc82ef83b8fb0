"""The files of value clips, which USD opens when a value at a time is first read."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from wmspec.core.limits import LAYERS


def clip_files(spec: Any) -> Iterator[str]:
    """Yield the asset paths of a prim's clips as written, and those in its folder that match a template.

    Raises TooLarge if a template matches too many files.
    """
    if not spec.HasInfo("clips"):
        return
    clips = spec.GetInfo("clips")
    for one in clips.values() if isinstance(clips, dict) else ():
        if not isinstance(one, dict):
            continue
        for path in [*(one.get("assetPaths") or ()), one.get("manifestAssetPath")]:
            if path:
                yield str(getattr(path, "path", path))
        if template := one.get("templateAssetPath"):
            yield from _matching(spec.layer.ComputeAbsolutePath(str(template)))


def _matching(template: str) -> Iterator[str]:
    """Yield the existing files of a template such as `clip.###.usd`, where `#` is a digit."""
    place = Path(template)
    if "#" not in place.name or not place.parent.is_dir():
        return
    pattern = re.compile(re.sub(r"(\\#)+", r"-?\\d+", re.escape(place.name)))
    for number, path in enumerate(sorted(place.parent.iterdir())):
        if number > LAYERS.most:
            raise LAYERS.exceeded()
        if pattern.fullmatch(path.name):
            yield str(path)
