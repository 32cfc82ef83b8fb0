"""Untrusted photographs and clips: read as what their endings say and as nothing else, and from their folder."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from tests.trust.made import wmspec

ROW = "question,pictures,options,answer\nWhich?,{name},a;b,a\n"


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    (tmp_path / "photos").mkdir()
    Image.effect_noise((32, 32), 80).save(tmp_path / "photos/good.png")
    return tmp_path / "photos"


def recast(photos: Path, name: str) -> tuple[int, str]:
    table = photos.parent / "t.csv"
    table.write_text(ROW.format(name=name))
    result = wmspec("import-images", table, "--images", photos, "-o", photos.parent / "out")
    assert (photos.parent / "out").exists() == (result.exit_code == 0)
    return result.exit_code, result.output


def test_a_photograph_is_read(photos: Path) -> None:
    assert recast(photos, "good.png")[0] == 0


@pytest.mark.parametrize("name", ["link.png", "link.mp4"])
def test_a_photograph_that_is_a_link_out_of_its_folder(photos: Path, name: str) -> None:
    Image.effect_noise((32, 32), 80).save(photos.parent / "secret.png")
    (photos / name).symlink_to("../secret.png")
    code, reported = recast(photos, name)
    assert code == 2
    assert f"`{name}` is a link that leads out of the folder" in reported


@pytest.mark.parametrize("kind", ["EPS", "PDF", "PCX", "ICO"])
def test_a_photograph_is_no_file_of_another_kind(photos: Path, kind: str) -> None:
    """Pillow would start Ghostscript for what begins as PostScript, whatever it is called."""
    Image.new("RGB", (32, 32)).save(photos / "odd.png", kind)
    code, reported = recast(photos, "odd.png")
    assert code == 2
    assert "`odd.png` cannot be read: it is damaged, or no picture" in reported


def test_a_photograph_of_too_many_pixels(photos: Path) -> None:
    Image.new("1", (8192, 8200)).save(photos / "bomb.png")
    code, reported = recast(photos, "bomb.png")
    assert code == 2
    assert "`bomb.png` has more than 67,108,864 pixels" in reported


@pytest.mark.parametrize(
    "content",
    [
        "ffconcat version 1.0\nfile good.png\n",
        "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nfile:///etc/hostname\n#EXT-X-ENDLIST\n",
        "",
        "\0" * 100,
    ],
)
def test_a_clip_that_names_other_files_is_no_clip(photos: Path, content: str) -> None:
    pytest.importorskip("imageio_ffmpeg")
    (photos / "clip.mp4").write_text(content)
    code, reported = recast(photos, "clip.mp4")
    assert code == 2
    assert "`clip.mp4` cannot be read" in reported
