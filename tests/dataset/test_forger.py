"""A forger who rewrites manifest, counts and hashes is found, or verify says what it cannot find."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.dataset.forger import Forger, as_rejected, dot_truth, dotted, move_truth, nudge, older, swap_pictures
from tests.endtoend.test_commands import SPEED
from tests.engines import installed
from tests.films.conftest import SHOVE
from wmspec.api import generate
from wmspec.api.attesting import attest, check
from wmspec.api.verifying import verify

SEED = 2**62 + 99


def quiet(text: str) -> None:
    """Receive warnings."""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    installed("mujoco")
    folder = tmp_path_factory.mktemp("forger")
    generate([SPEED, SHOVE], folder / "out", per_task=4, backend="mujoco", size=64, seed=SEED, workers=0, tell=quiet)
    return folder / "out"


@pytest.fixture(scope="module")
def seal(made: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("seal")
    attest(made, folder / "out", workers=0, tell=quiet)
    return folder / "out/seal.json"


def pictured(forger: Forger) -> list[dict[str, Any]]:
    """The rows whose options are pictures."""
    return [row for row in forger.of("shove") if row["option_image"]]


def answers(forger: Forger) -> None:
    for row in forger.of("shove")[::3]:
        move_truth(row)


def options(forger: Forger) -> None:
    for row in pictured(forger):
        swap_pictures(row)


def picture(forger: Forger) -> None:
    for row in forger.of("speed_tabletop"):
        row["context"][0] = nudge(row["context"][0])


def dot(forger: Forger) -> None:
    for row in pictured(forger):
        dot_truth(row)


def dot_of_another_version(forger: Forger) -> None:
    dot(forger)
    older(forger)


def large_dot_of_another_version(forger: Forger) -> None:
    row = forger.of("shove")[0]
    row["context"][0] = dotted(row["context"][0], side=8)
    older(forger)


def removed(forger: Forger) -> None:
    row = forger.of("shove").pop(3)
    forger.plan["tasks"]["shove"].remove(row["index"])


def removed_last(forger: Forger) -> None:
    row = forger.of("shove").pop()
    forger.plan["tasks"]["shove"].remove(row["index"])


def claimed_rejected(forger: Forger) -> None:
    for row in (forger.of("shove").pop(2), forger.of("shove").pop(3)):
        forger.manifest["rejected"]["list"].append(as_rejected(row))
        counts = forger.manifest["rejected"]["count"]
        counts["alike"] = counts.get("alike", 0) + 1


def doubled(forger: Forger) -> None:
    rows = forger.of("speed_tabletop")
    rows.insert(1, rows[0])


def added(forger: Forger) -> None:
    rows, indices = forger.of("speed_tabletop"), forger.plan["tasks"]["speed_tabletop"]
    index = next(i for i in range(999) if i not in indices)
    rows.append(rows[-1] | {"id": "speed_tabletop/0000-0000-0000-0000", "index": index})
    forger.plan["tasks"]["speed_tabletop"] = sorted([*indices, index])


def order(forger: Forger) -> None:
    rows = forger.of("shove")
    rows[0], rows[2] = rows[2], rows[0]


def factor(forger: Forger) -> None:
    for row in forger.of("speed_tabletop"):
        row["nuisance.slow"] += 1e-9


def spec_text(forger: Forger) -> None:
    name = next(name for name in forger.manifest["specs"] if name.endswith("shove.wms"))
    forger.spec(name, lambda text: text.replace("damping: 0 Hz", "damping: 1 Hz"))


def bundled_text(forger: Forger) -> None:
    forger.spec("<library>/tabletop.wms", lambda text: text + "# mine\n")


def readme(forger: Forger) -> None:
    forger.text("README.md", lambda text: text.replace("## Use and limits", "## Use\n\nHumans: 12 %.\n\n## Limits"))


def card(forger: Forger) -> None:
    forger.text("README.md", lambda text: text.replace("task_categories:", "pretty_name: Other\ntask_categories:"))


def licence(forger: Forger) -> None:
    forger.text("README.md", lambda text: text.replace('- "unknown"', '- "cc0-1.0"'))


def croissant(forger: Forger) -> None:
    forger.text("croissant.json", lambda text: text.replace('"sc:Dataset"', '"sc:Dataset",\n "url": "https://x.test"'))


def example(forger: Forger) -> None:
    shutil.copy(forger.folder / "examples/shove.webp", forger.folder / "examples/speed_tabletop.webp")


def extra(forger: Forger) -> None:
    (forger.folder / "data/shove/loader.py").write_text("print(1)\n")
    forger.manifest["files"]["data/shove/loader.py"] = "0" * 64


def title(forger: Forger) -> None:
    forger.manifest["tasks"]["shove"]["title"] = "Another title"


def metadata(forger: Forger) -> None:
    path = next(path for path in forger.rows if "shove" in path)
    forger.tables[path] = forger.tables[path].replace_schema_metadata({"note": "the answer is 1"})


FORGERIES = (
    answers, picture, dot_of_another_version, removed, claimed_rejected, added, order, spec_text, readme, croissant,
    extra,
)  # fmt: skip
MORE_FORGERIES = (
    options, dot, doubled, licence, large_dot_of_another_version, removed_last, factor, bundled_text, card, example,
    title, metadata,
)  # fmt: skip
#: The forgeries that no check without an engine finds; the others need no sample.
SAMPLED = (options, picture, dot, dot_of_another_version, large_dot_of_another_version, claimed_rejected, spec_text)


@pytest.fixture
def forged(made: Path, tmp_path: Path) -> Callable[[Callable[[Forger], None]], Path]:
    def forge(change: Callable[[Forger], None]) -> Path:
        shutil.copytree(made, tmp_path / "out")
        forger = Forger(tmp_path / "out")
        change(forger)
        forger.save()
        return tmp_path / "out"

    return forge


def test_an_untouched_dataset_is_the_same(made: Path) -> None:
    result = verify(made, workers=0, tell=quiet)
    assert (result.verdict, result.differences) == ("same", ())
    assert result.power.found >= 0.99
    assert "states its seed" in result.limits[0]


@pytest.mark.parametrize(
    "change",
    [*FORGERIES, *(pytest.param(change, marks=pytest.mark.slow) for change in MORE_FORGERIES)],
    ids=lambda change: change.__name__,
)
def test_a_forgery_is_found_by_default(
    change: Callable[[Forger], None], forged: Callable[[Callable[[Forger], None]], Path]
) -> None:
    result = verify(forged(change), sample=None if change in SAMPLED else 1, workers=0, tell=quiet)
    assert result.verdict == "different", result.limits


def test_a_licence_that_is_rewritten_everywhere_is_stated_as_not_covered(
    forged: Callable[[Callable[[Forger], None]], Path], seal: Path
) -> None:
    folder = forged(lambda forger: forger.manifest.update(licence="CC0-1.0"))
    result = verify(folder, sample=1, workers=0, tell=quiet)
    assert result.verdict == "different", "card and metadata still state the licence of the specs"
    assert "CC0-1.0" in result.limits[0]
    assert "the file manifest.json is not what was sealed" in check(folder, seal)


@pytest.mark.parametrize("name", ["README.md", "croissant.json", "extra.txt", "examples/shove.webp"])
def test_a_seal_covers_every_file(name: str, made: Path, seal: Path, tmp_path: Path) -> None:
    shutil.copytree(made, tmp_path / "out")
    assert check(tmp_path / "out", seal) == ()
    with (tmp_path / "out" / name).open("ab") as file:
        file.write(b" ")
    (sentence,) = check(tmp_path / "out", seal)
    assert name in sentence
