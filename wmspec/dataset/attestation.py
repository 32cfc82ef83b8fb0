"""Attestations: published hashes of a private dataset, against which a later copy can be checked.

An attestation holds hashes of the seed, the specs and the rows. Questions cannot be guessed from them. Anyone who
receives the dataset, or generates it again from specs and seed, can compare.
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

#: The smallest seed that resists an exhaustive search, and the parameters of scrypt: one trial takes 16 MB and about 50
#: ms.
MIN_SECRET_SEED, SCRYPT_COST = 1 << 62, {"n": 1 << 14, "r": 8, "p": 1}


class Attestation(BaseModel):
    """How a dataset was made: scrypt hash of its seed, SHA-256 of its specs and Parquet files by name."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    seed: str
    specs: dict[str, str]
    shards: dict[str, str]
    engines: tuple[str, ...]
    size: tuple[int, int]
    consensus: str
    versions: dict[str, str]

    @classmethod
    def read(cls, path: Path) -> Attestation:
        """Read an attestation. Raises WmsError if the file is not one."""
        try:
            return cls.model_validate_json(path.read_bytes())
        except (OSError, ValidationError) as error:
            raise WmsError(f"{path} is no seal", help="`wmspec attest DATASET -o FOLDER` writes one") from error

    @property
    def text(self) -> str:
        """Return the content of the file."""
        return json.dumps(self.model_dump(mode="json"), indent=1, sort_keys=True) + "\n"


def attest(dataset: DatasetReader) -> Attestation:
    """Return the attestation of a dataset. Raises WmsError if its seed could be guessed."""
    manifest = dataset.manifest
    if abs(manifest["seed"]) < MIN_SECRET_SEED:
        raise WmsError(
            f"the dataset was made with the seed {manifest['seed']}, which anyone can find by trying",
            help="make it with a long one: wmspec generate ... "
            "--seed $(python3 -c 'import secrets; print(2**62 + secrets.randbits(62))')",
        )
    return _hashes(manifest)


def differences(seal: Attestation, dataset: DatasetReader) -> Iterator[str]:
    """Yield the differences between a dataset and its attestation, as sentences."""
    here = _hashes(dataset.manifest)
    if here.seed != seal.seed:
        yield "the seed differs"
    for kind, there, now in (("spec", seal.specs, here.specs), ("file", seal.shards, here.shards)):
        yield from _changed_files(kind, there, now)
    for name in ("engines", "size", "consensus", "versions"):
        if getattr(here, name) != getattr(seal, name):
            yield f"its {name} are {getattr(here, name)!r}, and were {getattr(seal, name)!r}"


def _hashes(manifest: Mapping[str, Any]) -> Attestation:
    return Attestation(
        seed=hashlib.scrypt(str(manifest["seed"]).encode(), salt=b"wmspec seal", **SCRYPT_COST).hex(),
        specs={name: _digest(spec["text"]) for name, spec in manifest["specs"].items()},
        shards={path: shard["sha256"] for path, shard in manifest["shards"].items()},
        engines=tuple(manifest["engines"]),
        size=(manifest["size"][0], manifest["size"][1]),
        consensus=manifest["consensus"],
        versions=manifest["versions"],
    )


def _changed_files(kind: str, there: Mapping[str, str], here: Mapping[str, str]) -> Iterator[str]:
    for name in sorted({*there, *here}):
        if name not in here:
            yield f"the {kind} {name} is missing"
        elif name not in there:
            yield f"the {kind} {name} is not in the attestation"
        elif there[name] != here[name]:
            yield f"the {kind} {name} is not what was sealed"


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
