"""Pictures are sent in the format, size and detail that the user chose, and results say so."""

from __future__ import annotations

import base64
import io
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from tests.evaluate.loopback import loopback
from tests.evaluate.made import in_pictures
from wmspec.cli import main
from wmspec.core.diagnostics import WmsError
from wmspec.eval.models.images import AS_THEY_ARE, ImageOptions

pytest.importorskip("openai")


def png(width: int, height: int) -> bytes:
    out = io.BytesIO()
    Image.fromarray(np.full((height, width, 3), 90, np.uint8)).save(out, "PNG")
    return out.getvalue()


def test_the_default_changes_no_byte() -> None:
    assert AS_THEY_ARE.encode(png(40, 30)) == ("image/png", png(40, 30))
    assert AS_THEY_ARE.record is None


@pytest.mark.parametrize(
    ("form", "size", "kind", "shape"),
    [
        ("jpeg:90", None, "image/jpeg", (40, 30)),
        ("JPG", 80, "image/jpeg", (80, 60)),
        ("webp:50", 20, "image/webp", (20, 15)),
        ("png", 20, "image/png", (20, 15)),
    ],
)
def test_format_and_size(form: str, size: int | None, kind: str, shape: tuple[int, int]) -> None:
    found, content = ImageOptions.parse(form, size, None).encode(png(40, 30))
    assert found == kind
    assert Image.open(io.BytesIO(content)).size == shape


@pytest.mark.parametrize("form", ["gif", "jpeg:0", "jpeg:101", "png:90", "jpeg:", ""])
def test_an_unknown_format_is_an_error(form: str) -> None:
    with pytest.raises(WmsError, match="expected png, or jpeg or webp"):
        ImageOptions.parse(form, None, None)


def test_requests_hold_what_was_chosen_and_results_name_it(tmp_path: Path) -> None:
    dataset, out = in_pictures(tmp_path / "d", 2), tmp_path / "r.parquet"
    with loopback() as server:
        args = ["evaluate", str(dataset), "-m", "openai:first", "--base-url", server.address, "-o", str(out)]
        more = ["--image-format", "jpeg:90", "--image-size", "64", "--image-detail", "low", "--limit", "1"]
        done = CliRunner().invoke(main, args + more, env={"OPENAI_API_KEY": "none"})
        assert done.exit_code == 0, done.output
        images = [p["image_url"] for p in server.bodies[0]["messages"][-1]["content"] if p["type"] == "image_url"]
        again = CliRunner().invoke(main, [*args, "--limit", "1"], env={"OPENAI_API_KEY": "none"})
    assert {image["detail"] for image in images} == {"low"}
    for image in images:
        assert image["url"].startswith("data:image/jpeg;base64,")
        assert max(Image.open(io.BytesIO(base64.b64decode(image["url"].split(",")[1]))).size) == 64
    assert json.loads((tmp_path / "r.json").read_text())["asked"]["images"] == "jpeg:90 64 px low"
    assert again.exit_code == 2
    assert "images differ" in again.output
