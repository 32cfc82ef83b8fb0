"""What is published of a dataset that stays private, so that anyone can tell later whether what is shown is it.

The seal has hashes of the seed, of the specs and of the rows. From none of them can a question be guessed; whoever gets
the dataset, or makes it again from the specs and the seed, can compare.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.reader import DatasetReader

#: A smaller seed can be found by trying. A larger one cannot: to try one takes 16 MB and some 50 ms of a processor.
SECRET, COST = 1 << 62, {"n": 1 << 14, "r": 8, "p": 1}


class Seal(BaseModel):
    """How a dataset was made, and hashes of it: scrypt of its seed, SHA-256 of specs and of files of rows, by name."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    seed: str
    specs: dict[str, str]
    shards: dict[str, str]
    engines: tuple[str, ...]
    size: tuple[int, int]
    consensus: str
    versions: dict[str, str]

    @classmethod
    def read(cls, path: Path) -> Seal:
        """Raises WmsError if the file is no seal."""
        try:
            return cls.model_validate_json(path.read_bytes())
        except (OSError, ValidationError) as error:
            raise WmsError(f"{path} is no seal", help="`wmspec seal DATASET -o FOLDER` writes one") from error

    @property
    def text(self) -> str:
        """The seal as a file."""
        return json.dumps(self.model_dump(mode="json"), indent=1, sort_keys=True) + "\n"


def sealed(dataset: DatasetReader) -> Seal:
    """The seal of a dataset. Raises WmsError if its seed could be guessed."""
    manifest = dataset.manifest
    if abs(manifest["seed"]) < SECRET:
        raise WmsError(
            f"the dataset was made with the seed {manifest['seed']}, which anyone can find by trying",
            help="make it with a long one: wmspec generate ... "
            "--seed $(python3 -c 'import secrets; print(2**62 + secrets.randbits(62))')",
        )
    return _hashed(manifest)


def differences(seal: Seal, dataset: DatasetReader) -> Iterator[str]:
    """What of a dataset is not what was sealed, in sentences; nothing if it is the one."""
    here = _hashed(dataset.manifest)
    if here.seed != seal.seed:
        yield "the seed is another"
    for kind, there, now in (("spec", seal.specs, here.specs), ("file", seal.shards, here.shards)):
        yield from _differing(kind, there, now)
    for name in ("engines", "size", "consensus", "versions"):
        if getattr(here, name) != getattr(seal, name):
            yield f"its {name} are {getattr(here, name)!r}, and were {getattr(seal, name)!r}"


def _hashed(manifest: Mapping[str, Any]) -> Seal:
    return Seal(
        seed=hashlib.scrypt(str(manifest["seed"]).encode(), salt=b"wmspec seal", **COST).hex(),
        specs={name: _digest(spec["text"]) for name, spec in manifest["specs"].items()},
        shards={path: shard["sha256"] for path, shard in manifest["shards"].items()},
        engines=tuple(manifest["engines"]),
        size=(manifest["size"][0], manifest["size"][1]),
        consensus=manifest["consensus"],
        versions=manifest["versions"],
    )


def _differing(kind: str, there: Mapping[str, str], here: Mapping[str, str]) -> Iterator[str]:
    for name in sorted({*there, *here}):
        if name not in here:
            yield f"the {kind} {name} is gone"
        elif name not in there:
            yield f"the {kind} {name} was not sealed"
        elif there[name] != here[name]:
            yield f"the {kind} {name} is not what was sealed"


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
