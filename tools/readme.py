"""Make the picture of the README, `docs/images/questions.jpg`: two questions, large enough to be answered.

python -m tools.readme
"""

from __future__ import annotations

import textwrap
from pathlib import Path

from matplotlib import get_data_path
from PIL import Image, ImageDraw, ImageFont

import wmspec

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs/images/questions.jpg"
ENGINE = "mujoco"
WIDTH, MARGIN, GAP = 1600, 40, 16  # px
INK, PALE = (25, 25, 25), (110, 116, 128)
#: The vertical part of a picture of `collide` that shows the motion.
BAND = 0.27, 0.66
FONTS = Path(get_data_path()) / "fonts/ttf"


class Page:
    """A white page that is filled from top to bottom."""

    def __init__(self) -> None:
        self.image = Image.new("RGB", (WIDTH, 4000), "white")
        self.draw = ImageDraw.Draw(self.image)
        self.y = MARGIN

    def text(self, text: str, size: int, left: int = MARGIN, *, bold: bool = False, color: tuple = INK) -> None:
        """Write text, wrapped at the right margin."""
        font = ImageFont.truetype(str(FONTS / f"DejaVuSans{'-Bold' if bold else ''}.ttf"), size)
        for line in textwrap.wrap(text, int((WIDTH - MARGIN - left) / (0.62 * size))):
            self.draw.text((left, self.y), line, color, font)
            self.y += int(size * 1.4)

    def row(self, pictures: list[Image.Image], labels: list[str], width: int = WIDTH - 2 * MARGIN) -> None:
        """Put labelled pictures side by side, over a width from the left margin."""
        each = (width - GAP * (len(pictures) - 1)) // len(pictures)
        top = self.y
        for i, (picture, label) in enumerate(zip(pictures, labels, strict=True)):
            left = MARGIN + i * (each + GAP)
            self.y = top
            self.text(label, 26, left, bold=len(label) == 1, color=INK if len(label) == 1 else PALE)
            height = round(picture.height * each / picture.width)
            self.image.paste(picture.resize((each, height), Image.Resampling.LANCZOS), (left, self.y + 4))
        self.y += height + 4 + GAP

    def saved(self, path: Path) -> None:
        """Write the filled part of the page."""
        self.image.crop((0, 0, WIDTH, self.y + MARGIN - GAP)).save(path, quality=88, optimize=True)


def relation(page: Page) -> None:
    """A question whose options are words."""
    task = next(t for t in wmspec.load_all(ROOT / "specs/perception/space/relation.wms") if t.name == "relation_room")
    question = task[0].ask(ENGINE, size=(768, 768))[0]
    page.text(question.text, 32, bold=True)
    page.y += GAP
    top = page.y
    page.row([Image.fromarray(p.rgb) for p in question.context], ["from the front", "from above"], 1000)
    bottom, page.y = page.y, top + 130
    for letter, option in zip("ABCD", question.options, strict=True):
        page.text(f"{letter}   {option.text}", 32, 1090)
        page.y += GAP
    page.y = bottom


def collide(page: Page) -> None:
    """A question whose options are pictures of what could have happened."""
    task = wmspec.load(ROOT / "specs/prediction/mechanistic/collide.wms")
    question = task[9].ask(ENGINE, size=(1040, 1040))[0]
    page.text(question.text, 32, bold=True)
    page.y += GAP
    shown = [f"{picture.time - question.context[0].time:.2g} s" for picture in question.context]
    page.row([_band(p.rgb) for p in question.context], shown)
    page.row([_band(o.picture.rgb) for o in question.options], list("ABCD"))


def _band(rgb: object) -> Image.Image:
    picture = Image.fromarray(rgb)
    return picture.crop((0, round(BAND[0] * picture.height), picture.width, round(BAND[1] * picture.height)))


def main() -> None:
    """Write the picture."""
    page = Page()
    relation(page)
    page.y += 2 * MARGIN
    collide(page)
    page.saved(PICTURE)


if __name__ == "__main__":
    main()
