"""Photographs and clips as a dataset: the example of the docs, what becomes of pictures, and every mistake reported."""

from __future__ import annotations

import io
import json
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image, ImageCms

from tests.command import wmspec
from wmspec.cli import main
from wmspec.dataset.build.identity import identity
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.image_import.table import COLUMNS

DOCS = Path(__file__).parents[2] / "docs" / "recast"
HEAD = "question,pictures,options,answer"


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(a) for a in arguments])


def recast(folder: Path, *lines: str, head: str = HEAD) -> Result:
    """Recast a table of these lines with the pictures of `folder`."""
    table = folder / "table.csv"
    table.write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")
    return run("import-images", table, "--images", folder / "pictures", "-o", folder / "out", "--size", 128)


def rows(folder: Path) -> list[dict[str, Any]]:
    dataset = DatasetReader.open(folder)
    return [row for task in dataset.tasks for row in dataset.rows(task)]


def opened(picture: dict[str, Any]) -> Image.Image:
    return Image.open(io.BytesIO(picture["bytes"]))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Pictures: a red and a blue square, a wide one, and a clip in which grey becomes brighter."""
    place = tmp_path / "pictures"
    place.mkdir()
    Image.new("RGB", (40, 40), (200, 30, 30)).save(place / "red.png")
    Image.new("RGB", (40, 40), (30, 30, 200)).save(place / "blue.png")
    Image.new("RGB", (400, 100), (30, 200, 30)).save(place / "wide.jpg")
    frames = [Image.new("L", (32, 32), 20 * i) for i in range(9)]
    frames[0].save(place / "grows.gif", save_all=True, append_images=frames[1:], duration=200)
    return tmp_path


# ---------------------------------------------------------------- the example of the docs


@pytest.fixture(scope="session")
def example(tmp_path_factory: pytest.TempPathFactory) -> Path:
    skimage = pytest.importorskip("skimage")
    out = tmp_path_factory.mktemp("example") / "photographs"
    done = run("import-images", DOCS / "photographs.csv", "--images", Path(skimage.__file__).parent / "data", "-o", out)
    assert done.exit_code == 0, done.output
    return out


def test_the_example_is_a_dataset_like_any_other(example: Path) -> None:
    dataset = DatasetReader.open(example)
    dataset.intact()
    made = rows(example)
    assert len(made) == dataset.manifest["rows"] == 8
    assert {row["task"]: row["answer_value"] for row in made}["material_photo"] == "grass.png"
    assert all(row["option_kind"][row["answer"]] == "truth" for row in made)
    assert sorted(p.name for p in example.iterdir()) == ["README.md", "croissant.json", "data", "manifest.json"]


def test_the_commands_of_the_docs_work(tmp_path: Path) -> None:
    """As they stand in docs/recast.md, one after the other."""
    pytest.importorskip("skimage")
    pytest.importorskip("statsmodels")
    block, *_ = re.findall(r"```sh\n(.*?)```", (DOCS.parent / "recast.md").read_text(), re.DOTALL)
    first, *commands = block.splitlines()
    here = f'python() {{ {shlex.quote(sys.executable)} "$@"; }}\n{first}\necho "$IMAGES"'
    images = subprocess.run(["bash", "-ec", here], capture_output=True, text=True, check=True).stdout.strip()
    (tmp_path / "docs").symlink_to(DOCS.parent)
    said = ""
    for line in commands:
        program, *words = shlex.split(line.replace("$IMAGES", images))
        assert program == "wmspec"
        said += wmspec(*words, folder=tmp_path).output
    assert re.search(r"^Of \d+ tasks?, ", said, re.MULTILINE)
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    assert {line["system"]: line["average"]["value"] for line in report["tables"][0]["lines"]}["oracle"] == 1.0


def test_the_docs_name_every_column() -> None:
    said = (DOCS.parent / "recast.md").read_text()
    assert [name for name in COLUMNS if f"`{name}`" not in said] == []


def test_hugging_face_reads_the_example(example: Path) -> None:
    datasets = pytest.importorskip("datasets")
    files = str(example / "data" / "color_photo" / "*.parquet")
    (first, *_) = datasets.load_dataset(
        "parquet", data_files=files, split="train", cache_dir=str(example.parent / "hf")
    )
    assert first["context"][0].size == (512, 512)


def test_the_example_states_every_licence(example: Path) -> None:
    card = (example / "README.md").read_text()
    assert "not stated" not in card
    assert "| coffee.png | Rachel Michetti, courtesy of Pikolo Espresso Bar | CC0 |" in card


def test_the_same_table_gives_the_same_bytes(example: Path, tmp_path: Path) -> None:
    skimage = pytest.importorskip("skimage")
    run(
        "import-images",
        DOCS / "photographs.csv",
        "--images",
        Path(skimage.__file__).parent / "data",
        "-o",
        tmp_path / "again",
    )
    for path in (p for p in example.rglob("*") if p.is_file()):
        assert path.read_bytes() == (tmp_path / "again" / path.relative_to(example)).read_bytes(), path


# ---------------------------------------------------------------- pictures


def test_pictures_lose_their_metadata_and_stand_upright(folder: Path) -> None:
    exif = Image.Exif()
    exif[0x0112], exif[0x010F], exif[0x8825] = 6, "Maker of cameras", {1: "N", 2: (48.0, 8.0, 0.0)}
    image = np.zeros((20, 60, 3), np.uint8)
    image[:, :30] = (250, 0, 0)  # red at the left: at the top, once turned by 90 degrees to the right
    Image.fromarray(image).save(folder / "pictures" / "turned.jpg", exif=exif, quality=95, comment=b"secret")
    assert recast(folder, "Which?,turned.jpg,a;b,a").exit_code == 0
    (row,) = rows(folder / "out")
    seen = opened(row["context"][0])
    assert seen.size == (20, 60)
    assert np.asarray(seen)[5, 10, 0] > 200
    assert np.asarray(seen)[55, 10, 0] < 60
    assert not {"exif", "icc_profile", "xmp"} & set(seen.info)
    assert not seen.getexif()
    assert b"Maker" not in row["context"][0]["bytes"]


def test_large_pictures_are_made_smaller_and_keep_their_form(folder: Path) -> None:
    assert recast(folder, "Which?,wide.jpg;red.png,a;b,a").exit_code == 0
    (row,) = rows(folder / "out")
    assert [opened(p).size for p in row["context"]] == [(128, 32), (40, 40)]
    assert row["context_time"] == [0.0, 1.0]


def test_transparency_is_white_and_greys_stay_grey(folder: Path) -> None:
    Image.new("RGBA", (20, 20), (9, 9, 9, 0)).save(folder / "pictures" / "clear.png")
    Image.fromarray(np.full((20, 20), 32768, np.uint16)).save(folder / "pictures" / "deep.png")
    assert recast(folder, "Which?,clear.png;deep.png,a;b,a").exit_code == 0
    clear, deep = (np.asarray(opened(p)) for p in rows(folder / "out")[0]["context"])
    assert (clear == 255).all()
    assert abs(int(deep[0, 0, 0]) - 127) <= 1


def test_colours_are_brought_to_srgb(folder: Path) -> None:
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    Image.new("RGB", (20, 20), (200, 30, 30)).save(folder / "pictures" / "tagged.png", icc_profile=profile)
    assert recast(folder, "Which?,tagged.png,a;b,a").exit_code == 0
    seen = opened(rows(folder / "out")[0]["context"][0])
    assert abs(np.asarray(seen, int)[0, 0] - (200, 30, 30)).max() <= 2
    assert not {"exif", "icc_profile", "xmp"} & set(seen.info)


def test_a_clip_gives_pictures_evenly_and_their_times(folder: Path) -> None:
    done = recast(folder, "Which?,grows.gif,a;b,a,5", head=f"{HEAD},frames")
    assert done.exit_code == 0, done.output
    (row,) = rows(folder / "out")
    assert row["context_time"] == pytest.approx([0, 0.4, 0.8, 1.2, 1.6])
    assert [int(np.asarray(opened(p))[0, 0, 0]) for p in row["context"]] == pytest.approx([0, 40, 80, 120, 160], abs=4)


def test_a_film_gives_pictures_too(folder: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    from wmspec.dataset.build.video import mp4

    mp4([Image.new("RGB", (64, 64), (25 * i,) * 3) for i in range(10)], 5.0, folder / "pictures" / "film.mp4")
    done = recast(folder, "Which?,film.mp4,a;b,a,4", head=f"{HEAD},frames")
    assert done.exit_code == 0, done.output
    (row,) = rows(folder / "out")
    assert row["context_time"] == pytest.approx([0, 0.6, 1.2, 1.8])
    assert [int(np.asarray(opened(p))[0, 0, 0]) for p in row["context"]] == pytest.approx([0, 75, 150, 225], abs=8)


# ---------------------------------------------------------------- rows


def test_episodes_groups_factors_and_differences(folder: Path) -> None:
    head = f"{HEAD},episode,group,name,factor.color,factor.size,difference,quantity"
    done = recast(
        folder,
        "What colour?,red.png,red;blue,red,one,home,color,red,1,,",
        "How large?,red.png,small;large,small,one,home,size,red,1,2.5,size(a) / size(b)",
        "What colour?,blue.png,red;blue,blue,two,home,color,blue,1,,",
        head=head,
    )
    assert done.exit_code == 0, done.output
    first, second, third = rows(folder / "out")
    places = [(0, 0), (0, 1), (1, 0)]
    assert [r["id"] for r in (first, second, third)] == [identity(0, "table", *place, "camera") for place in places]
    assert {r["block"] for r in (first, second, third)} == {0}
    assert first["group.color"] == third["group.color"] != first["group.size"]
    assert (first["factor.color"], first["factor.size"]) == ("red", 1.0)
    assert second["difference"] == {"name": "size(a) / size(b)", "unit": "", "value": 2.5}
    assert first["difference"] is None


def test_an_open_question_has_a_number(folder: Path) -> None:
    head = f"{HEAD},unit,within"
    assert recast(folder, "How high?,red.png,,1.5,m,0.1", head=head).exit_code == 0
    (row,) = rows(folder / "out")
    assert (row["answer"], row["answer_number"], row["answer_unit"], row["answer_within"]) == (None, 1.5, "m", 0.1)


def test_options_may_be_pictures(folder: Path) -> None:
    assert recast(folder, "Which is red?,wide.jpg,blue.png;red.png,red.png").exit_code == 0
    (row,) = rows(folder / "out")
    assert row["option_text"] is None
    assert row["answer"] == 1
    assert [opened(p).size for p in row["option_image"]] == [(40, 40)] * 2


def test_a_spreadsheets_mark_and_line_breaks_are_read(folder: Path) -> None:
    (folder / "table.csv").write_bytes(f'\ufeff{HEAD}\r\n"Which,\r\nthen?",red.png,a;b,a\r\n'.encode())
    done = run("import-images", folder / "table.csv", "--images", folder / "pictures", "-o", folder / "out")
    assert done.exit_code == 0, done.output
    assert rows(folder / "out")[0]["text"] == "Which,\r\nthen?"


# ---------------------------------------------------------------- mistakes


@pytest.mark.parametrize(
    ("line", "column", "said"),
    [
        (",red.png,a;b,a", "question", "it is empty"),
        ("Q,,a;b,a", "pictures", "it is empty"),
        ("Q,rad.png,a;b,a", "pictures", "there is no `rad.png` in {folder}; did you mean `red.png`?"),
        ("Q,../table.csv,a;b,a", "pictures", "`../table.csv` leads out of the folder"),
        ("Q,words.txt,a;b,a", "pictures", "`words.txt` has an unsupported format"),
        ("Q,torn.png,a;b,a", "pictures", "`torn.png` cannot be read: it is damaged, or no picture"),
        ("Q,tiny.png,a;b,a", "pictures", "`tiny.png` has 3 × 3 pixels"),
        ("Q,grows.gif;red.png,a;b,a", "pictures", "a clip must be the only file"),
        ("Q,red.png,a,a", "options", "there is only one option"),
        ("Q,red.png,a;b;a,a", "options", "`a` is there twice"),
        ("Q,red.png,a;;b,a", "options", "one of them is empty"),
        ("Q,red.png,blue.png;large,large", "options", "`large` is not a photograph, but other options are"),
        ("Q,red.png,blue.png;copy.png,copy.png", "options", "blue.png and copy.png are the same picture"),
        ("Q,red.png,left;right,rihgt", "answer", "`rihgt` is not one of the options; did you mean `right`?"),
        ("Q,red.png,,seven", "answer", "`seven` is not a number"),
        ("Q,red.png,,7", "within", "it is empty"),
        ("Q,red.png,a;b,a,,,,,1", "within", "the question has options"),
        ("Q,red.png,a;b,a,My Task", "task", "`My Task` is not a name"),
        ("Q,red.png,a;b,a,,9", "frames", "there is no clip to take them from"),
        ("Q,grows.gif,a;b,a,,99", "frames", "99 is not a number of pictures"),
        ("Q,grows.gif,a;b,a,,12", "frames", "`grows.gif` has 9 pictures, 12 are wanted"),
        ("Q,red.png;blue.png,a;b,a,,,1", "times", "1 times for 2 pictures"),
        ("Q,red.png;blue.png,a;b,a,,,2;1", "times", "the times are not increasing"),
        ("Q,red.png,a;b,a,,,,5", "quantity", "it is empty"),
    ],
)
def test_mistake_is_reported_with_row_column_and_remedy(folder: Path, line: str, column: str, said: str) -> None:
    pictures = folder / "pictures"
    (pictures / "words.txt").write_text("words")
    (pictures / "torn.png").write_bytes((pictures / "red.png").read_bytes()[:60])
    Image.new("RGB", (3, 3)).save(pictures / "tiny.png")
    Image.open(pictures / "blue.png").save(pictures / "copy.png", optimize=True)
    head = f"{HEAD},task,frames,times,difference,within"
    done = recast(folder, "Right?,red.png,a;b,a", line, head=head)
    assert done.exit_code == 2
    reported = f"{folder / 'table.csv'}:3: column `{column}`: {said.format(folder=pictures)}"
    assert reported in done.output, done.output
    assert not (folder / "out").exists()


def test_all_mistakes_are_reported_at_once(folder: Path) -> None:
    done = recast(folder, ",red.png,a;b,c", "Q,none.png,a;b,a", "Q,red.png,a;b,a", "Q,red.png,b;a,b")
    assert done.exit_code == 2
    wrong = (
        ":2: column `question`",
        ":2: column `answer`",
        ":3: column `pictures`",
        ":5: the row repeats the question",
    )
    for place in wrong:
        assert f"table.csv{place}" in done.output, done.output


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", ":1: there is no column `question`"),
        (b"question,pictures,options,anwser\n", ":1: there is no column `answer`"),
        (b"question,pictures,options,answer,sauce\n", "column `sauce` is not known; did you mean `source`?"),
        (b"question,pictures,options,answer,answer\n", "there are two columns `answer`"),
        (b"question,pictures,options,answer\n", "the table has no rows"),
        (b"question,pictures,options,answer\nQ,red.png,a;b,a,more\n", ":2: the row has 5 cells, the table 4 columns"),
        (b"question,pictures,options,answer\nQ,\xff,a;b,a\n", ":2: this is not UTF-8"),
        (b'question,pictures,options,answer\nQ,"red.png"x,a;b,a\n', ":2: this is not CSV"),
    ],
)
def test_file_without_a_table_is_an_error(folder: Path, content: bytes, said: str) -> None:
    (folder / "table.csv").write_bytes(content)
    done = run("import-images", folder / "table.csv", "--images", folder / "pictures", "-o", folder / "out")
    assert (done.exit_code, said in done.output) == (2, True), done.output


def test_a_task_has_one_dimension(folder: Path) -> None:
    lines = ("Q,red.png,a;b,a,perception.time", "R,red.png,a;b,a,perception.space")
    done = recast(folder, *lines, head=f"{HEAD},dimension")
    assert done.exit_code == 2
    assert "table.csv:3: column `dimension`: task `table` is of perception.space here" in done.output


def test_foreign_folders_stay_and_own_output_is_replaced(folder: Path) -> None:
    assert recast(folder, "Q,red.png,a;b,a").exit_code == 0
    assert recast(folder, "Q,blue.png,a;b,b").exit_code == 0
    assert [row["answer_value"] for row in rows(folder / "out")] == ["b"]
    (folder / "mine").mkdir()
    (folder / "mine" / "letter.txt").write_text("dear")
    done = run("import-images", folder / "table.csv", "--images", folder / "pictures", "-o", folder / "mine")
    assert done.exit_code == 2
    assert "did not write" in done.output
    assert [p.name for p in (folder / "mine").iterdir()] == ["letter.txt"]


def test_unused_pictures_and_missing_licences_are_reported(folder: Path) -> None:
    done = recast(folder, "Q,red.png,a;b,a")
    assert "1 rows have no licence" in done.output
    assert "pictures without a question: blue.png, grows.gif, wide.jpg" in done.output
