"""A trial of a spec, as the page of `watch` and editors start it."""

from http.client import HTTPConnection
from pathlib import Path
from threading import Thread

import pytest

from wmspec.editor.page import HOST, PageServer
from wmspec.editor.trial import try_spec
from wmspec.editor.watch import PreviewOptions, Watch

GOOD = """use tabletop
task lower : perception.space.height {
  factor tall in [4, 12] cm
  object a { shape: box  size: (6 cm, 6 cm, tall)  color: red   on: table at (-10 cm, 0) }
  object b { shape: box  size: (6 cm, 6 cm, 8 cm)  color: blue  on: table at (10 cm, 0) }
  observe front at [0 s]
  question "Is the red box lower than the blue one?" { answer height(a) < height(b) }
}
"""


def test_trial_prints_the_kept_questions(tmp_path: Path) -> None:
    spec = tmp_path / "lower.wms"
    spec.write_text(GOOD)
    found = try_spec(spec)
    assert "lower" in found
    assert "kept" in found


def test_trial_prints_mistakes_of_the_spec(tmp_path: Path) -> None:
    spec = tmp_path / "lower.wms"
    spec.write_text(GOOD.replace("height(a)", "heigth(a)"))
    assert "heigth" in try_spec(spec)


@pytest.mark.parametrize("path", ["/trial"])
def test_the_page_of_watch_tries_its_spec(tmp_path: Path, path: str) -> None:
    spec = tmp_path / "lower.wms"
    spec.write_text(GOOD.replace("height(a)", "heigth(a)"))
    server = PageServer(Watch(spec, PreviewOptions("")), 0)
    thread = Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        connection = HTTPConnection(HOST, server.server_address[1], timeout=60)
        connection.request("GET", path)
        assert "heigth" in connection.getresponse().read().decode()
    finally:
        server.shutdown()
        server.server_close()
