"""Layout of text and pictures for contact sheets."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache

from PIL import Image, ImageDraw, ImageFont

Picture = Image.Image
Font = ImageFont.FreeTypeFont | ImageFont.ImageFont

PAPER = "white"
BLACK = "#1a1c1e"
GREY = "#5f6670"
PALE = "#c9ced6"
GREEN = "#12843f"


@dataclass(frozen=True)
class Style:
    """The size (px), colour and weight of a text."""

    size: int
    color: str = BLACK
    bold: bool = False

    @property
    def height(self) -> int:
        """The height of a line (px)."""
        return round(self.size * 1.4)


@cache
def font(size: int, bold: bool) -> Font:
    """Return DejaVu if the system has it, which covers most scripts; else Pillow's built-in font."""
    try:
        return ImageFont.truetype("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf", size)
    except OSError:
        return ImageFont.load_default(size)


def blank(width: int, height: int) -> Picture:
    """Return an empty picture."""
    return Image.new("RGB", (max(width, 1), max(height, 1)), PAPER)


def width_of(text: str, style: Style) -> int:
    """Return the width of a text on one line (px)."""
    return round(font(style.size, style.bold).getlength(text)) + 1


def paragraph(text: str, style: Style, width: int, centred: bool = False) -> Picture:
    """Return a text broken into lines of at most `width` px."""
    lines = list(_lines(text, style, width))
    paper = blank(width, style.height * len(lines))
    draw = ImageDraw.Draw(paper)
    for n, line in enumerate(lines):
        left = (width - width_of(line, style)) // 2 if centred else 0
        middle = n * style.height + style.height // 2
        draw.text((left, middle), line, fill=style.color, font=font(style.size, style.bold), anchor="lm")
    return paper


def _lines(text: str, style: Style, width: int) -> Iterator[str]:
    line = ""
    for word in _words(text, style, width):
        longer = f"{line} {word}".strip()
        if line and width_of(longer, style) > width:
            yield line
            line = word
        else:
            line = longer
    yield line


def _words(text: str, style: Style, width: int) -> Iterator[str]:
    """Yield the words of a text; words wider than a line are split."""
    for word in text.split():
        rest = word
        while width_of(rest, style) > width and len(rest) > 1:
            fits = next(n for n in range(len(rest) - 1, 0, -1) if n == 1 or width_of(rest[:n], style) <= width)
            yield rest[:fits]
            rest = rest[fits:]
        yield rest


def tick(size: int) -> Picture:
    """Return a green tick."""
    big = blank(4 * size, 4 * size)  # supersampled for smooth edges
    points = [(0.5 * size, 2.2 * size), (1.5 * size, 3.2 * size), (3.5 * size, 0.8 * size)]
    ImageDraw.Draw(big).line(points, fill=GREEN, width=round(0.6 * size), joint="curve")
    return big.resize((size, size), Image.Resampling.LANCZOS)


def hstack(parts: Sequence[Picture], gap: int = 0, middle: bool = False) -> Picture:
    """Join pictures from left to right, aligned at the top (or the middle)."""
    height = max((p.height for p in parts), default=1)
    paper = blank(sum(p.width for p in parts) + gap * (len(parts) - 1), height)
    left = 0
    for part in parts:
        paper.paste(part, (left, (height - part.height) // 2 if middle else 0))
        left += part.width + gap
    return paper


def vstack(parts: Iterable[Picture], gap: int = 0) -> Picture:
    """Join pictures from top to bottom, aligned at the left."""
    pieces = list(parts)
    paper = blank(max((p.width for p in pieces), default=1), sum(p.height for p in pieces) + gap * (len(pieces) - 1))
    top = 0
    for piece in pieces:
        paper.paste(piece, (0, top))
        top += piece.height + gap
    return paper


def pad(part: Picture, margin: int) -> Picture:
    """Add a margin to a picture."""
    paper = blank(part.width + 2 * margin, part.height + 2 * margin)
    paper.paste(part, (margin, margin))
    return paper


def grid(
    rows: Iterable[Sequence[tuple[str, Picture]]], label: Callable[[str, int], Picture], gap: int, margin: int = 12
) -> Picture:
    """Return rows of pictures, each under its label, which `label` draws from its text and the picture's width (px)."""
    lines = [hstack([vstack([label(text, picture.width), picture]) for text, picture in row], gap) for row in rows]
    return pad(vstack(lines, 2 * gap), margin)


def frame(part: Picture, color: str, thickness: int, room: int) -> Picture:
    """Add a frame of `thickness` px within `room` px on every side; the size does not depend on `thickness`."""
    paper = pad(part, room)
    outside = room - thickness
    box = (outside, outside, paper.width - 1 - outside, paper.height - 1 - outside)
    ImageDraw.Draw(paper).rectangle(box, outline=color, width=thickness)
    return paper


def rule(width: int, color: str = PALE, thickness: int = 2) -> Picture:
    """Return a horizontal line."""
    return Image.new("RGB", (width, thickness), color)
