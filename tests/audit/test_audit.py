"""The audit finds what is wrong with a dataset, says when it cannot tell, and leaves a sound one alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.audit.made import Ask, inject_rarely, make, make_all, picture, race, roll, shuffled, spec
from tests.dataset.made import make as pictured
from tests.dataset.made import plan
from tests.examples import slow_except
from tests.shared import Shared
from wmspec.compile.design.design import Design
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.audit import balance
from wmspec.dataset.audit.audit import audit
from wmspec.dataset.audit.cases import full_size_pictures, units
from wmspec.dataset.audit.duplicates import duplicate_findings, duplicates, mark_faint
from wmspec.dataset.audit.model import Audit, Finding
from wmspec.dataset.build.files import digest
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.reader import DatasetReader
from wmspec.runtime.questions.model import Number, Picture, QuestionRow, Strength

Audited = Callable[[str], Audit]

#: The datasets that are audited as a whole, with probes: their task, what asks, and how many instances they have.
AUDITED: dict[str, tuple[str, Ask, int]] = {
    "race": ("race", race(), 240),
    "race at full power": ("race", race(), 240),
    "race of 30": ("race", race(), 30),
    "race of 12": ("race", race(), 12),
    "race level": ("race", race(level=True), 160),
    "race favoured": ("race", race(favoured=0.85), 160),
    "race telling": ("race", race(telling=True), 80),
    "roll": ("roll", roll(), 160),
    "roll colour": ("roll", roll("colour"), 84),
    "roll middle": ("roll", roll("middle"), 160),
}

#: Those whose probes are tested for their power.
POWERFUL = {"race at full power", "roll"}


@pytest.fixture(scope="session")
def audited(shared: Shared) -> Audited:
    """The audit of one of these datasets, made once for all tests that look at it."""

    def found(name: str) -> Audit:
        def whole() -> Audit:
            with TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
                if name not in POWERFUL:
                    inject_rarely(patch)
                return look(make(Path(folder) / "made", *AUDITED[name]))

        return shared.value(f"audit/{name}", whole)

    return found


def look(folder: Path, most: int = 2000) -> Audit:
    return audit(folder, most, lambda task, count: None)


def failing(found: Audit, check: str = "") -> list[Finding]:
    return [f for f in found.findings if f.verdict == "fails" and check in f.check]


def doubled(folder: Path) -> list[Finding]:
    """What the audit finds about duplicates: the same as in a whole one, which takes a hundred times as long."""
    dataset = DatasetReader.open(folder)
    (task,) = dataset.tasks
    (unit,) = units(dataset, task, 2000)
    return duplicate_findings(unit, mark_faint(unit, duplicates(unit), partial(full_size_pictures, dataset, task)))


def balanced(folder: Path) -> list[Finding]:
    """What it finds about the balance of places and answers, likewise."""
    dataset = DatasetReader.open(folder)
    tested = (balance.tests(unit) for task in dataset.tasks for unit in units(dataset, task, 2000))
    return [balance.judge(test) for test in balance.corrected_tests([test for tests in tested for test in tests])]


def share(found: Audit, sees: str) -> float:
    (probe,) = [p for p in found.probes if p.sees == sees]
    return probe.accuracy


@pytest.mark.slow
def test_any_number_of_workers_finds_the_same(tmp_path: Path) -> None:
    folder, message = make_all(tmp_path / "two", {"race": race(), "roll": roll()}, 40), list[str]()
    alone, shared = (audit(folder, 24, lambda task, count: message.append(task), workers) for workers in (0, 2))
    assert asdict(shared) == asdict(alone)
    assert {p.task for p in alone.probes} == {"race", "roll"}
    assert message == ["race", "roll"] * 2


@pytest.mark.parametrize("name", slow_except(["race"], ["race", "race at full power", "roll"]))
def test_a_sound_dataset_passes(name: str, audited: Audited) -> None:
    found = audited(name)
    assert found.passed, failing(found)
    held = [f for f in found.findings if f.check == "shortcut" and f.verdict in ("holds", "unclear")]
    checks = {"files", "counts", "balance", "duplicates", "options", "shortcut", "groups", "stability", "legibility"}
    checks |= {"metadata", "vocabulary"} if name != "roll" else {"metadata"}
    assert {f.check for f in found.findings} == checks
    judged = [p for p in found.probes if p.judged]
    assert len(judged) >= 4
    assert any(p.sees.startswith("the best single picture") for p in judged)
    assert all(p.luck for p in judged)
    (line,) = found.summaries
    assert line.verdict != "fails"
    assert line.groups >= 30
    assert all("would have been detected" in f.what for f in held)


# ---------------------------------------------------------------- shortcuts


@pytest.mark.parametrize(
    ("name", "sees", "least"),
    [
        ("race level", "the best single picture (picture 2: pixels)", 0.7),
        ("race favoured", "the place of the options", 0.75),
        ("race telling", "the options", 0.99),
        ("race telling", "the text", 0.99),
        ("roll colour", "the options", 0.7),
        ("roll colour", "the options' colours", 0.9),
        pytest.param("roll middle", "the options", 0.6, marks=pytest.mark.slow),
    ],
)
def test_a_shortcut_is_found(name: str, sees: str, least: float, audited: Audited) -> None:
    found = audited(name)
    assert share(found, sees) > least
    assert any(f"from {sees} alone" in f.what for f in failing(found, "shortcut"))


def test_other_probes_ignore_a_revealing_last_picture(audited: Audited) -> None:
    found = audited("race level")
    assert all("from the best single picture (picture 2: pixels)" in f.what for f in failing(found))
    (message,) = [f for f in found.findings if "from picture 2: pixels alone" in f.what]
    assert message.verdict == "reported"
    assert "only the best of these probes is judged" in message.what


def still(question: QuestionRow, random: np.random.Generator) -> QuestionRow:
    """The same question with one picture: who is ahead?"""
    moving = race(level=True)(question, random)
    return replace(moving, text="Which ball is ahead?", context=moving.context[1:])


@pytest.mark.usefixtures("roughly")
def test_a_question_about_one_moment_may_be_answered_from_its_picture(tmp_path: Path) -> None:
    found = look(make(tmp_path / "made", "race", still, 100))
    assert share(found, "picture 1: pixels") > 0.7
    assert found.passed
    (message,) = [f for f in found.findings if "from picture 1: pixels alone" in f.what]
    assert message.verdict == "reported"
    assert "as many moments as the answer requires" in message.what


@pytest.mark.usefixtures("roughly")
def test_standing_answers_may_follow_from_any_picture(tmp_path: Path) -> None:
    def standing(question: QuestionRow, random: np.random.Generator) -> QuestionRow:
        return replace(race(level=True)(question, random), standing=True)

    found = look(make(tmp_path / "made", "race", standing, 100))
    assert share(found, "picture 2: pixels") > 0.7
    assert found.passed
    assert any("from picture 2: pixels alone" in f.what and f.verdict == "reported" for f in found.findings)


def test_too_few_questions_are_reported(audited: Audited) -> None:
    found = audited("race of 12")
    assert found.passed
    assert any("groups are too few" in f.what and f.verdict == "unclear" for f in found.findings)
    assert found.summaries[0].verdict == "unclear"
    found = audited("race of 30")
    assert any(f.verdict == "unclear" and "too few questions for a conclusion" in f.what for f in found.findings)


@pytest.mark.usefixtures("roughly")
def test_engines_are_not_counted_as_questions(tmp_path: Path) -> None:
    found = look(make(tmp_path / "made", "race", race(), 20, engines=("mujoco", "pybullet")))
    assert {p.questions for p in found.probes} == {20}
    assert max(sum(map(sum, t.counts)) for t in found.tests) == 20


# ---------------------------------------------------------------- balance


def leaning(question: QuestionRow, random: np.random.Generator) -> QuestionRow:
    """Red questions have the truth in the first place."""
    made = race()(question, random)
    first = question.factors["tone"] == "red"
    options = tuple(sorted(made.options, key=lambda o: (o.kind != "truth") == first))
    return replace(made, options=options, answer=[o.kind for o in options].index("truth"))


def test_place_that_depends_on_a_factor_fails(tmp_path: Path) -> None:
    found = balanced(make(tmp_path / "made", "race", leaning, 160))
    assert any("place of the truth depends on tone" in f.what for f in found if f.verdict == "fails")


def test_favoured_place_fails_and_names_the_deciding_factor(audited: Audited) -> None:
    found = audited("race favoured")
    assert any("the place of the truth is not uniform" in f.what for f in failing(found, "balance"))
    (decides,) = [f for f in found.findings if "answer depends on faster" in f.what]
    assert decides.verdict == "reported"


# ---------------------------------------------------------------- duplicates and options


def copied(contrary: bool, noise: int = 0, darker: int = 0) -> Ask:
    """The question of instance 40 is repeated as one other instance, with two rows of its pixels `darker`."""
    from tests.audit.made import blank

    def ask(question: QuestionRow, random: np.random.Generator) -> QuestionRow:
        if question.index != 41:
            return race()(question, random)
        source = race()(blank(Design(spec("race"), 3), 40, question.engine), np.random.default_rng(40))
        context = tuple(
            replace(p, rgb=p.rgb ^ random.integers(0, noise + 1, p.rgb.shape, np.uint8)) for p in source.context
        )
        for p in context:
            p.rgb[:2] -= np.uint8(darker)
        options = tuple(replace(o, kind="label" if o.kind == "truth" else "truth") for o in source.options)
        if contrary:
            return replace(
                question,
                text=source.text,
                context=context,
                options=options,
                answer=1 - (source.answer or 0),
                value="",
                evidence=source.evidence,
            )
        return replace(source, index=41, context=context)

    return ask


@pytest.mark.parametrize("noise", [0, 3])
def test_the_same_question_with_another_answer_fails(noise: int, tmp_path: Path) -> None:
    (finding,) = doubled(make(tmp_path / "made", "race", copied(True, noise), 160))
    assert finding.verdict == "fails"
    design = Design(spec("race"), 3)
    order = shuffled(design, sorted(design.sample(168)[:160]))
    names = [identity(3, "race", i, 0, "mujoco") for i, question in order.items() if question in (40, 41)]
    assert [name in finding.what for name in names] == [True, True]
    assert "different answers" in finding.what


def test_questions_distinct_only_at_full_size_are_reported(tmp_path: Path) -> None:
    (finding,) = doubled(make(tmp_path / "made", "race", copied(True, darker=5), 160))
    assert finding.verdict == "reported"
    assert "1 pair of questions are distinguishable only at full picture size" in finding.what


@pytest.mark.parametrize(("noise", "exact"), [(0, "1 to the byte"), (3, "0 to the byte")])
def test_duplicate_question_is_reported(noise: int, exact: str, tmp_path: Path) -> None:
    (finding,) = doubled(make(tmp_path / "made", "race", copied(False, noise), 160))
    assert finding.verdict == "reported"
    assert exact in finding.what


def test_options_that_look_the_same_fail(tmp_path: Path) -> None:
    (finding,) = failing(look(make(tmp_path / "made", "roll", roll(alike=True), 16)), "options")
    assert "the same option twice" in finding.what


# ---------------------------------------------------------------- open questions, stimulus differences


def counting(fickle: bool) -> Ask:
    """How many balls? Without options; the answer is the number of balls, or anything if it is `fickle`."""

    def ask(question: QuestionRow, random: np.random.Generator) -> QuestionRow:
        shown = 1 + question.index % 4
        count = int(random.integers(1, 5)) if fickle else shown
        balls = [(0.15 + 0.2 * i, 0.5, (20, 20, 20)) for i in range(shown)]
        return replace(
            question,
            text="How many?",
            context=(Picture("front", 0.0, picture(balls)),),
            answer=None,
            value=str(count),
            number=Number(count, "", 0.5),
            difference=Strength("count", "", count),
        )

    return ask


def test_an_open_question_has_no_shortcuts_and_no_places(tmp_path: Path) -> None:
    found = look(make(tmp_path / "made", "race", counting(fickle=False), 80))
    assert found.passed
    assert not found.probes
    assert {t.first for t in found.tests} == {"answer"}
    (spread,) = found.spreads
    assert (spread.name, spread.quantiles[0], spread.quantiles[-1]) == ("count", 1, 4)


def test_open_questions_about_the_same_pictures_have_the_same_answer(tmp_path: Path) -> None:
    (finding,) = failing(look(make(tmp_path / "made", "race", counting(fickle=True), 80)), "duplicates")
    assert "different answers" in finding.what


# ---------------------------------------------------------------- files


def shard(folder: Path) -> Path:
    return next((folder / "data").rglob("*.parquet"))


def forge(folder: Path, table: pa.Table) -> None:
    """Write another shard, and the manifest as if it had always been so."""
    path = shard(folder)
    before = digest(path)
    pq.write_table(table, path)
    manifest = folder / "manifest.json"
    manifest.write_text(manifest.read_text().replace(before, digest(path)))


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-100])


@pytest.mark.parametrize(
    ("damage", "said"),
    [(flip, "was modified"), (cut, "was modified"), (Path.unlink, "is missing")],
)
def test_every_damaged_file_is_named_and_what_is_whole_is_looked_at(
    damage: Callable[[Path], None], said: str, tmp_path: Path
) -> None:
    pictured(tmp_path, plan(count=5))
    wrong = sorted((tmp_path / "data/collide").iterdir())
    for path in wrong:
        damage(path)
    found = look(tmp_path)
    (files,) = failing(found, "files")
    assert files.task == "collide"
    assert all(f"{path.relative_to(tmp_path)} {said}" in files.what for path in wrong)
    assert "wmspec generate" in files.what
    assert [f.check for f in found.findings if f.task == "collide"] == ["files"]
    assert any(f.task == "motion_speed" and f.check == "counts" for f in found.findings)


@pytest.mark.parametrize("name", ["README.md", "croissant.json"])
def test_deleted_document_is_named_and_the_rest_checked(name: str, tmp_path: Path) -> None:
    folder = make(tmp_path, "race", race(), 16)
    (folder / name).unlink()
    found = look(folder)
    assert [f.what.partition(" is missing")[0] for f in failing(found)] == [name]
    assert found.tests


def test_rows_that_the_manifest_does_not_count_fail(tmp_path: Path) -> None:
    folder = make(tmp_path, "race", race(), 16)
    forge(folder, pq.read_table(shard(folder)).slice(1))
    assert "15 rows, 16 in the manifest" in failing(look(folder), "counts")[0].what


def test_an_answer_that_points_at_a_false_option_fails(tmp_path: Path) -> None:
    folder = make(tmp_path, "race", race(), 16)
    table = pq.read_table(shard(folder))
    wrong = [1 - a for a in table["answer"].to_pylist()[:1]] + table["answer"].to_pylist()[1:]
    place = table.schema.get_field_index("answer")
    forge(folder, table.set_column(place, table.schema.field(place), [wrong]))
    assert any("no or another true option" in f.what for f in failing(look(folder), "counts"))


def test_invalid_dataset_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(WmsError, match="no finished dataset"):
        look(tmp_path)


@pytest.mark.parametrize("key", ["", "{", '"shards"', '"dimension"', '"sha256": "'])
def test_damaged_manifest_is_an_error(key: str, tmp_path: Path) -> None:
    """It is cut off at the beginning or after the key, or lacks it."""
    manifest = make(tmp_path, "race", race(), 16) / "manifest.json"
    text = manifest.read_text()
    for damaged in (text.partition(key)[0] if key else "", text.replace(key, '"x' + key[1:]), "{}", "[]"):
        manifest.write_text(damaged)
        with pytest.raises(WmsError, match="not a manifest of `wmspec generate`"):
            look(tmp_path)
