"""Record the film of the README: an edited spec next to the page of `wmspec watch`.

python tools/screencast.py docs/images/watch.gif

The page is the real one, in Chromium (by playwright), with instances executed during the recording. Durations of frames
are constants, so the film is independent of the speed of the machine.
"""

from __future__ import annotations

import shutil
import sys
import threading
from collections.abc import Iterator
from contextlib import chdir
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from PIL import Image
from pygments import highlight
from pygments.formatters import HtmlFormatter

from wmspec.editor.page import PageServer
from wmspec.editor.pygments import WmsLexer
from wmspec.editor.watch import PreviewOptions, Watch

WIDE, LEFT, HIGH = 1160, 470, 640  # px: of the film, of the text, and their height
CARET, COLORS = "\ue000", 192
TYPED, READ, LOOKED = 90, 3500, 6500  # ms: a letter, a message, a picture

SPEC = """use room

task bump : custom {
  factor pace in [0.6, 0.9] m/s
  factor tone in [red, blue]

  object ball {
    shape: sphere  size: 14 cm
    color: tone
    on: floor at (-40 cm, 0)
  }
  object post {
    shape: cylinder  size: 14 cm
    color: yellow
    on: floor at (5 cm, 0)
  }

  action push = launch(ball, right, pace) at 0.1 s
  horizon 1.2 s

  observe front at [0 s, 0.4 s]

  question "The {tone} ball rolls. What next?" {
    answer frame(front, end)
    counterfactual still { without push }
    counterfactual aside {
      action push.direction: 30 deg
    }
  }
}
"""

#: Replaced text, its replacement, and the time (ms) that the result is shown.
EDITS = (
    ("size: 14 cm\n    color: yellow", "size: 24 cm\n    color: yellow", LOOKED),
    ("color: yellow", "color: green", LOOKED),
    ("(5 cm, 0)", "(5 cm, 0)  freiction: 0.05", READ),
    ("freiction: 0.05", "friction: 0.05", LOOKED),
    ("[0.6, 0.9] m/s", "[0.6, 0.9] m", READ),
    ("[0.6, 0.9] m\n", "[0.6, 1.5] m/s\n", LOOKED),
    ("shape: cylinder", "shape: cube", LOOKED),
    ("without push", "without puhs", READ),
    ("without puhs", "without push", LOOKED),
)

STYLE = f"""body {{ margin: 0; padding: 16px 18px; background: #fbfbf9; width: {LEFT - 36}px; }}
body pre {{ background: none; }}
pre {{ font: 13.5px/20px 'DejaVu Sans Mono', monospace; margin: 0; white-space: pre; }}
h1 {{ font: 600 13px 'DejaVu Sans', sans-serif; color: #777; margin: 0 0 12px; }}
i.caret {{ border-left: 2px solid #d33; margin-left: -1px; }}"""


@dataclass
class Film:
    """Frames and their durations (ms)."""

    frames: list[Image.Image] = field(default_factory=list)
    lasting: list[int] = field(default_factory=list)

    def add(self, frame: Image.Image, milliseconds: int) -> None:
        """Append a frame; one equal to the last extends its duration."""
        if self.frames and self.frames[-1].tobytes() == frame.tobytes():
            self.lasting[-1] += milliseconds
        else:
            self.frames.append(frame)
            self.lasting.append(milliseconds)

    def save(self, path: Path) -> None:
        """Write the film with one palette."""
        every = max(1, len(self.frames) // 16)
        sheet = Image.new("RGB", (WIDE, HIGH * len(self.frames[::every])))
        for i, frame in enumerate(self.frames[::every]):
            sheet.paste(frame, (0, HIGH * i))
        palette = sheet.quantize(COLORS, dither=Image.Dither.NONE)
        shown = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in self.frames]
        shown[0].save(path, save_all=True, append_images=shown[1:], duration=self.lasting, loop=0, optimize=True)


def typed(before: str, after: str) -> Iterator[tuple[str, int]]:
    """Yield the text and the caret while `before` becomes `after`, letter by letter."""
    start = next(i for i, (a, b) in enumerate(zip(before, after, strict=False)) if a != b)
    end = next(i for i, (a, b) in enumerate(zip(before[::-1], after[::-1], strict=False)) if a != b)
    end = min(end, len(before) - start, len(after) - start)
    tail = before[len(before) - end :]
    for kept in range(len(before) - end, start, -1):
        yield before[:kept] + tail, kept
    for made in range(start, len(after) - end + 1):
        yield after[:made] + tail, made


class Studio:
    """A text on the left, and the page of a watch on the right."""

    def __init__(self, browser: Any, watch: Watch, address: str) -> None:
        self._watch = watch
        self._text = browser.new_page(viewport={"width": LEFT, "height": HIGH})
        self._page = browser.new_page(viewport={"width": WIDE - LEFT, "height": HIGH})
        self._page.goto(address)
        self._version = -1

    def picture(self, text: str, caret: int) -> Image.Image:
        """Return a screenshot of both."""
        marked = text[:caret] + CARET + text[caret:]
        colored = highlight(marked, WmsLexer(), HtmlFormatter(nowrap=True, style="friendly"))
        colors = HtmlFormatter(style="friendly").get_style_defs("pre")
        code = colored.replace(f'<span class="err">{CARET}</span>', CARET).replace(CARET, '<i class="caret"></i>')
        self._text.set_content(f"<style>{STYLE}{colors}</style><h1>bump.wms</h1><pre>{code}</pre>")
        whole = Image.new("RGB", (WIDE, HIGH))
        for page, x in ((self._text, 0), (self._page, LEFT)):
            whole.paste(Image.open(BytesIO(page.screenshot())).convert("RGB"), (x, 0))
        return whole

    def saved(self, text: str) -> None:
        """Save the text and wait until the page is updated."""
        self._watch.path.write_text(text)
        while True:
            state = self._watch.after(self._version, 300)
            if state is None:
                raise SystemExit("the page does not follow")
            self._version = state.version
            if state.phase == "done":
                break
        self._page.wait_for_timeout(1500)


def play(studio: Studio, film: Film) -> None:
    """Record all edits."""
    text = SPEC
    studio.saved(text)
    film.add(studio.picture(text, 0), LOOKED)
    for written, instead, looked in EDITS:
        if text.count(written) != 1:
            raise SystemExit(f"{written!r} is there {text.count(written)} times")
        after = text.replace(written, instead)
        for shown, caret in typed(text, after):
            film.add(studio.picture(shown, caret), TYPED)
        text = after
        studio.saved(text)
        film.add(studio.picture(text, caret), looked)


def main(path: Path) -> None:
    """Record the film."""
    from playwright.sync_api import sync_playwright

    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    path = path.absolute()
    with TemporaryDirectory() as folder, chdir(folder), sync_playwright() as started:
        spec = Path("bump.wms")  # so that messages name it so
        spec.write_text(SPEC)
        watch = Watch(spec, PreviewOptions("mujoco", instances=2, size=160))
        server = PageServer(watch, 0)
        threads = [threading.Thread(target=watch.run), threading.Thread(target=server.serve_forever, args=(0.05,))]
        for thread in threads:
            thread.start()
        film = Film()
        try:
            browser = started.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
            play(Studio(browser, watch, f"http://127.0.0.1:{server.server_address[1]}/"), film)
            browser.close()
        finally:
            watch.stop()
            server.shutdown()
            server.server_close()
    film.save(path)
    print(f"{path}: {len(film.frames)} pictures, {sum(film.lasting) / 1000:.0f} s, {path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
