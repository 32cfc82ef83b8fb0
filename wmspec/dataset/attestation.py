"""Attestations: published hashes of a private dataset, against which a later copy can be checked.

An attestation holds hashes of the seed, the specs, the rows and every other file of the folder. Questions cannot be
guessed from them. Anyone who receives the dataset, or generates it again from specs and seed, can compare.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import FILE_BYTES
from wmspec.core.safe_io import open_file, read_bytes
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.verify.folder import folder_files

#: The smallest seed that resists an exhaustive search, and the parameters of scrypt: one trial takes 16 MB and about 50
#: ms.
MIN_SECRET_SEED, SCRYPT_COST = 1 << 62, {"n": 1 << 14, "r": 8, "p": 1}


class Attestation(BaseModel):
    """How a dataset was made: scrypt hash of its seed, SHA-256 of its specs and Parquet files by name.

    `files` are the BLAKE2b hashes of all other files of the folder by path, with a key that follows from the seed:
    plan and card are short enough that a plain hash would let others try seeds. It is None in earlier attestations.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    seed: str
    specs: dict[str, str]
    shards: dict[str, str]
    engines: tuple[str, ...]
    size: tuple[int, int]
    consensus: str
    versions: dict[str, str]
    files: dict[str, str] | None = None

    @classmethod
    def read(cls, path: Path) -> Attestation:
        """Read an attestation. Raises WmsError if the file is not one."""
        try:
            return cls.model_validate_json(read_bytes(path, FILE_BYTES))
        except (OSError, ValidationError) as error:
            raise WmsError(f"{path} is no seal", help="`wmspec attest DATASET -o FOLDER` writes one") from error

    @property
    def text(self) -> str:
        """Return the content of the file."""
        return json.dumps(self.model_dump(mode="json"), indent=1, sort_keys=True) + "\n"


#: How to make a dataset with a seed that nobody can guess.
LONG_SEED = "wmspec generate ... --seed $(python3 -c 'import secrets; print(2**62 + secrets.randbits(62))')"


def has_guessable_seed(dataset: DatasetReader) -> bool:
    """Whether anyone who has the specs can find the seed, and with it the answers, by trying."""
    return bool(abs(dataset.manifest["seed"]) < MIN_SECRET_SEED)


def attest(dataset: DatasetReader) -> Attestation:
    """Return the attestation of a dataset. Raises WmsError if its seed could be guessed."""
    manifest = dataset.manifest
    if has_guessable_seed(dataset):
        raise WmsError(
            f"the dataset was made with the seed {manifest['seed']}, which anyone can find by trying",
            help=f"make it with a long one: {LONG_SEED}",
        )
    return _hashes(dataset)


def differences(seal: Attestation, dataset: DatasetReader) -> Iterator[str]:
    """Yield the differences between a dataset and its attestation, as sentences."""
    here = _hashes(dataset)
    if here.seed != seal.seed:
        yield "the seed differs"
    compared = [("spec", seal.specs, here.specs), ("file", seal.shards, here.shards)]
    if seal.files is not None and here.seed == seal.seed and here.files is not None:
        compared.append(("file", seal.files, here.files))
    for kind, there, now in compared:
        yield from _changed_files(kind, there, now)
    for name in ("engines", "size", "consensus", "versions"):
        if getattr(here, name) != getattr(seal, name):
            yield f"its {name} are {getattr(here, name)!r}, and were {getattr(seal, name)!r}"


def _hashes(dataset: DatasetReader) -> Attestation:
    manifest = dataset.manifest
    seed = str(manifest["seed"]).encode()
    key = hashlib.scrypt(seed, salt=b"wmspec seal files", **SCRYPT_COST)
    return Attestation(
        seed=hashlib.scrypt(seed, salt=b"wmspec seal", **SCRYPT_COST).hex(),
        specs={name: hashlib.sha256(spec["text"].encode()).hexdigest() for name, spec in manifest["specs"].items()},
        shards={path: shard["sha256"] for path, shard in manifest["shards"].items()},
        engines=tuple(manifest["engines"]),
        size=(manifest["size"][0], manifest["size"][1]),
        consensus=manifest["consensus"],
        versions=manifest["versions"],
        files=dict(_other_files(dataset, key)),
    )


def _other_files(dataset: DatasetReader, key: bytes) -> Iterator[tuple[str, str]]:
    """Yield the path and keyed hash of every file that is no shard. Raises WmsError if one cannot be read."""
    for name in folder_files(dataset.folder):
        if name in dataset.manifest["shards"]:
            continue
        try:
            with open_file(dataset.folder / name) as file:
                digest = hashlib.file_digest(file, lambda: hashlib.blake2b(key=key, digest_size=32))
        except OSError as error:
            raise WmsError(f"{dataset.folder / name} cannot be read: {error.strerror}", help="remove it") from error
        yield name, digest.hexdigest()


def _changed_files(kind: str, there: Mapping[str, str], here: Mapping[str, str]) -> Iterator[str]:
    for name in sorted({*there, *here}):
        if name not in here:
            yield f"the {kind} {name} is missing"
        elif name not in there:
            yield f"the {kind} {name} is not in the attestation"
        elif there[name] != here[name]:
            yield f"the {kind} {name} is not what was sealed"
