"""What wmspec stands on is written down as it is: its versions, its licences, its parts."""

from __future__ import annotations

import json
import re
from importlib.metadata import PathDistribution
from pathlib import Path

from tools import supply

ROOT = Path(__file__).parents[2]


def pinned() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    return dict(line.split("==") for line in lines if not line.startswith("#"))


def test_every_requirement_has_a_lower_and_an_upper_bound() -> None:
    for requirement in supply.own(supply.BUILT):
        assert {s.operator for s in requirement.specifier} >= {">=", "<"}, requirement


def test_the_constraints_name_versions_that_fit_and_no_hosts() -> None:
    assert all(re.fullmatch(r"[a-z0-9-]+", name) and re.fullmatch(r"[0-9][\w.]*", v) for name, v in pinned().items())
    for requirement in supply.own(supply.BUILT):
        assert requirement.specifier.contains(pinned()[supply.name_of(requirement)]), requirement


def test_the_oldest_versions_are_those_of_the_bounds() -> None:
    oldest = dict(line.split("==") for line in supply.lowest().splitlines())
    for requirement in supply.own(supply.USED):
        version = oldest[supply.name_of(requirement)]
        assert requirement.specifier.contains(version), requirement
        assert f">={version}" in str(requirement.specifier), "another extra asks for a newer one: raise this one, too"


def test_the_page_of_licences_names_all_that_is_installed() -> None:
    page = (ROOT / "docs/licences.md").read_text()
    for name, of in supply.tree(supply.USED).items():
        assert f"| {name} | {supply.licence(of)} |" in page, "run `make generate`"
    assert supply.UNSTATED not in page


def test_a_licence_is_told_alike_however_a_release_states_it(tmp_path: Path) -> None:
    """A newer release may say in one header what an older one said in two: the page is of both."""
    old = "License: BSD-3-Clause\nClassifier: License :: OSI Approved :: BSD License"
    told = [
        supply.licence(_stated(tmp_path / str(i), how))
        for i, how in enumerate((old, "License-Expression: BSD-3-Clause"))
    ]
    assert told == ["BSD-3-Clause", "BSD-3-Clause"]
    assert supply.licence(_stated(tmp_path / "vague", old.replace("-3-Clause", ""))) == "BSD License"


def _stated(folder: Path, how: str) -> PathDistribution:
    folder.mkdir()
    (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: some\nVersion: 1.0\n{how}\n")
    return PathDistribution(folder)


def test_the_bill_of_materials_is_whole_and_always_the_same() -> None:
    bill = json.loads(supply.sbom())
    refs = {c["bom-ref"] for c in bill["components"]} | {bill["metadata"]["component"]["bom-ref"]}
    assert {edge["ref"] for edge in bill["dependencies"]} == refs
    assert all(set(edge["dependsOn"]) <= refs for edge in bill["dependencies"])
    assert {"mujoco", "numpy", "usd-core", "pebble"} <= {c["name"] for c in bill["components"]}
    assert supply.sbom() == supply.sbom()
