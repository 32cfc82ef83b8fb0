"""What wmspec stands on, as it is installed here: versions for CI, licences, a bill of materials; and the oldest.

python -m tools.supply constraints > constraints.txt
python -m tools.supply lowest > out/lowest.txt
python -m tools.supply licences > docs/licences.md
python -m tools.supply sbom > out/sbom.json
"""

from __future__ import annotations

import json
import sys
import tomllib
from collections.abc import Iterable, Iterator
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.licenses import InvalidLicenseExpression, canonicalize_license_expression
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from wmspec import __version__

ROOT = Path(__file__).parent.parent

#: What users install, and what those who build wmspec need besides.
USED = ("mujoco", "pybullet", "sapien", "meshes", "video", "evaluate", "audit", "photo", "ray", "report", "lsp")
BUILT = (*USED, "dev", "docs", "notebooks")

#: Licences that ask something of those who pass the package on, and what wmspec does about it.
SAID = {
    "LGPL": "used as it is, as a library of its own, which anyone may replace: nothing of it is in wmspec",
    "MPL": "used as it is: nothing of it is in wmspec",
    "mitsuba-oidn": "its wheels carry Open Image Denoise, which is under the Apache licence 2.0",
    "imageio-ffmpeg": "its wheels carry FFmpeg, which is under the GPL and is started as a program of its own",
}

#: Said of a package whose licence nothing says.
UNSTATED = "not stated"
#: Packages whose metadata say nothing of their licence that a program could read, and what their own files say.
KNOWN = {"pybullet": "Zlib", "sapien": "MIT"}


def tree(extras: Iterable[str]) -> dict[str, Distribution]:
    """The installed packages that wmspec needs with these extras, and those that these need, by name, in order."""
    needed: dict[str, Distribution] = {}
    waiting = [(str(canonicalize_name(r.name)), frozenset(r.extras)) for r in own(extras)]
    done = set()
    while waiting:
        name, wanted = waiting.pop()
        if (name, wanted) in done:
            continue
        done.add((name, wanted))
        try:
            needed[name] = distribution(name)
        except PackageNotFoundError:
            continue
        waiting += [(canonicalize_name(r.name), frozenset(r.extras)) for r in _requirements(needed[name], wanted)]
    needed.pop("wmspec", None)
    return dict(sorted(needed.items()))


def own(extras: Iterable[str]) -> list[Requirement]:
    """What wmspec itself asks for with these extras, and with those that they name."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    asked = [Requirement(text) for text in project["dependencies"]]
    waiting = list(extras)
    for extra in waiting:
        for requirement in map(Requirement, project["optional-dependencies"][extra]):
            if requirement.name == "wmspec":
                waiting += [e for e in requirement.extras if e not in waiting]
            else:
                asked.append(requirement)
    return asked


def _requirements(of: Distribution, extras: Iterable[str]) -> Iterator[Requirement]:
    for text in of.requires or ():
        requirement = Requirement(text)
        if requirement.marker is None or any(requirement.marker.evaluate({"extra": e}) for e in ("", *extras)):
            yield requirement


def licence(of: Distribution) -> str:
    """The licence that a package states, in few words: by its name at SPDX, which releases seldom change."""
    about = of.metadata
    name = canonicalize_name(about["Name"])
    classified = [c.rpartition(" :: ")[2] for c in about.get_all("Classifier") or () if c.startswith("License :: ")]
    first = (about["License"] or "").strip().partition("\n")[0]
    named = (about["License-Expression"] or "").strip() or _spdx(first)
    stated = named or ", ".join(c for c in classified if c != "OSI Approved")
    told = stated or KNOWN.get(name) or (first if 0 < len(first) < 60 else "") or UNSTATED
    return " ".join(told.replace("|", "/").split())


def _spdx(text: str) -> str:
    """A licence that is told in SPDX's names, as these are written; nothing if it is not."""
    try:
        return canonicalize_license_expression(text)
    except InvalidLicenseExpression:
        return ""


def constraints() -> str:
    """Every package with its version, and nothing of where it comes from."""
    lines = [f"{name}=={of.version.partition('+')[0]}" for name, of in tree(BUILT).items()]
    return "\n".join(["# What CI installs: `python -m tools.supply constraints`.", *lines]) + "\n"


def lowest() -> str:
    """The oldest version of each package that users may have: the lower bounds of what wmspec itself asks for."""
    bounds = {name_of(r): s.version for r in own(USED) for s in r.specifier if s.operator == ">="}
    return "".join(f"{name}=={version}\n" for name, version in sorted(bounds.items()))


_HEAD = """\
# Licences

wmspec is under the MIT licence. This is what it needs, with all extras but `local` (models on this machine), each under
the licence that it states. `make generate` makes this page, and a test holds it. None of it is in
wmspec's own archives.
"""


def licences() -> str:
    """The licences of all that users install, as a page."""
    rows = [(name, licence(of)) for name, of in tree(USED).items()]
    lines = [*_HEAD.splitlines(), "", "| package | licence |", "|---|---|"]
    lines += [f"| {name} | {told} |" for name, told in rows]
    noted = [(name, told, why) for name, told in rows for word, why in SAID.items() if word in f"{name} {_words(told)}"]
    lines += ["", "Those that ask something of whoever passes them on:", ""]
    lines += [f"- {name} ({told}): {why}." for name, told, why in noted]
    return "\n".join(lines) + "\n"


def _words(told: str) -> str:
    """A licence with the short names that its long one has."""
    long = {"Lesser General Public": "LGPL", "Mozilla Public": "MPL"}
    return told + "".join(short for name, short in long.items() if name in told)


def sbom() -> str:
    """A bill of materials (CycloneDX 1.6): the same bytes for the same packages."""
    needed = tree(USED)
    components = [
        {
            "type": "library",
            "bom-ref": _purl(of),
            "name": name,
            "version": of.version,
            "purl": _purl(of),
            "licenses": [{"license": {"name": licence(of)}}],
        }
        for name, of in needed.items()
    ]
    ours = f"pkg:pypi/wmspec@{__version__}"
    asked = {ours: own(USED)} | {_purl(of): list(_requirements(of, ())) for of in needed.values()}
    edges = [
        {"ref": ref, "dependsOn": sorted({_purl(needed[n]) for r in of if (n := name_of(r)) in needed})}
        for ref, of in asked.items()
    ]
    subject = {"type": "application", "bom-ref": ours, "name": "wmspec", "version": __version__}
    bom = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": subject | {"licenses": [{"license": {"id": "MIT"}}]}},
        "components": components,
        "dependencies": edges,
    }
    return json.dumps(bom, indent=1) + "\n"


def name_of(requirement: Requirement) -> str:
    """The name of the package that is asked for, as packages are compared."""
    return str(canonicalize_name(requirement.name))


def _purl(of: Distribution) -> str:
    return f"pkg:pypi/{canonicalize_name(of.metadata['Name'])}@{of.version}"


if __name__ == "__main__":
    sys.stdout.write({"constraints": constraints, "lowest": lowest, "licences": licences, "sbom": sbom}[sys.argv[1]]())
