"""Requirements have bounds on both sides, and the constraints of CI lie within them."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tools import install

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
EXTRAS = {name: [Requirement(text) for text in texts] for name, texts in PROJECT["optional-dependencies"].items()}
REQUIREMENTS = [
    *map(Requirement, PROJECT["dependencies"]),
    *(requirement for extra in EXTRAS.values() for requirement in extra if requirement.name != "wmspec"),
]


def test_every_requirement_has_a_lower_and_an_upper_bound() -> None:
    for requirement in REQUIREMENTS:
        assert {s.operator for s in requirement.specifier} >= {">=", "<"}, requirement


def test_extras_that_share_a_package_have_the_same_lower_bound() -> None:
    """`make lowest` installs every extra at once: a lower bound that another extra exceeds is never tried."""
    bounds: dict[str, set[str]] = {}
    for requirement in REQUIREMENTS:
        lower = {s.version for s in requirement.specifier if s.operator == ">="}
        bounds.setdefault(canonicalize_name(requirement.name), set()).update(lower)
    assert not {name: versions for name, versions in bounds.items() if len(versions) > 1}


def test_the_constraints_name_versions_that_fit_and_no_hosts() -> None:
    lines = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if not line.startswith("#")]
    assert all(re.fullmatch(r"[a-z0-9-]+==[0-9][\w.]*", line) for line in lines)
    pinned = dict(line.split("==") for line in lines)
    # Models on this machine are too large for CI, and the conformance cases are of this repository.
    unpinned = {requirement.name for extra in ("local", "conformance") for requirement in EXTRAS[extra]}
    for requirement in REQUIREMENTS:
        if requirement.name not in unpinned:
            assert requirement.specifier.contains(pinned[canonicalize_name(requirement.name)]), requirement


LISTED = """:env:.cert='/etc/ca.crt'
:env:.constraint='file:///a%20b/constraints.txt'
global.constraint='/etc/other.txt'
global.extra-index-url='https://one.example/simple file:///two'
global.index-url='https://example.org/simple'
install.find-links='/wheels'
"""


def test_uv_installs_under_the_settings_of_pip() -> None:
    settings = install.effective(LISTED)
    assert settings["index-url"] == "https://example.org/simple"
    assert " ".join(install.options(settings)) == (
        "--index-strategy=unsafe-best-match --constraint /a b/constraints.txt"
        " --index https://one.example/simple --index file:///two --find-links /wheels"
    )
    assert "--no-index" in install.options(install.effective("global.no-index='true'\n"))
