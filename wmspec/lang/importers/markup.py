"""Bounded XML reader: no DTDs, no entities, limited size; elements keep their lines."""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from wmspec.core.diagnostics import suggestion
from wmspec.core.limits import XML_BYTES, XML_DEPTH, XML_ELEMENTS
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import open_file
from wmspec.lang.importers.model import Faults, UnreadableAsset

#: A value of xacro with a default, such as `$(optenv HUSKY_IMU_XYZ 0.19 0 0.149)`.
_OPTIONAL = re.compile(r"\$\(optenv\s+\w+\s+([^)]*)\)")
#: Maximum magnitude of any quantity (SI).
MAX_MAGNITUDE = 1e6


@dataclass
class Element:
    """An element: tag, attributes, children and location, such as `cabinet.urdf:12: joint hinge`."""

    tag: str
    attributes: dict[str, str]
    line: int
    file: str
    children: list[Element] = field(default_factory=list)

    @property
    def where(self) -> FilePlace:
        """File, line and name of the element."""
        name = self.attributes.get("name", "")
        return FilePlace(self.file, self.line, f"`{self.tag}{' ' + name[:60] if name else ''}`")

    def all(self, tag: str) -> list[Element]:
        """Return the children with a tag."""
        return [child for child in self.children if child.tag == tag]


class Reader:
    """Reads elements and their numeric attributes; errors are added to the faults."""

    def __init__(self, faults: Faults) -> None:
        self.faults = faults

    def known(self, e: Element, attributes: Collection[str], children: Collection[str] = ()) -> None:
        """Report unknown attributes and children, which are ignored; prefixed ones belong to other programs."""
        for name in e.attributes:
            if name not in attributes and ":" not in name and name != "xmlns":
                hint = suggestion(name, attributes) or "remove it"
                self.faults.approximate(e.where, f"`{name}` of `{e.tag}` is not supported", "ignored", hint)
        for child in e.children:
            if child.tag not in children and ":" not in child.tag:
                hint = suggestion(child.tag, children) or "remove it"
                self.faults.approximate(child.where, f"`{child.tag}` in `{e.tag}` is not supported", "ignored", hint)

    def only(self, e: Element, tag: str) -> Element | None:
        """Return the child with a tag, if any; report duplicates."""
        elements = e.all(tag)
        if len(elements) > 1:
            self.faults.add(elements[1].where, f"`{e.tag}` has more than one `{tag}`", "remove one")
        return elements[0] if elements else None

    def text(self, e: Element, name: str) -> str:
        """Return a required attribute."""
        if not e.attributes.get(name):
            self.faults.add(e.where, f"it needs `{name}`", f'write {name}="..."')
        return e.attributes.get(name, "")

    def number(self, e: Element, name: str, default: float | None = None, *, above: float = -math.inf) -> float:
        """Return a number, required unless it has a default."""
        if name not in e.attributes and default is not None:
            return default
        (value,) = self.numbers(e, name, 1, above=above)
        return value

    def numbers(
        self, e: Element, name: str, count: int, default: tuple[float, ...] | None = None, *, above: float = -math.inf
    ) -> tuple[float, ...]:
        """Return `count` numbers; errors are reported and replaced by ones."""
        if name not in e.attributes and default is not None:
            return default
        shown = e.attributes.get(name, "")[:60]
        try:  # as in Bullet, commas separate too
            values = tuple(float(word) for word in _OPTIONAL.sub(r"\1", self.text(e, name)).replace(",", " ").split())
        except ValueError:
            values = ()
        if len(values) > count > 1:
            self.faults.approximate(
                e.where, f'{name}="{shown}" has more than {count} numbers', "the first", "correct it"
            )
            values = values[:count]
        if name in e.attributes and len(values) != count:
            what = "a number" if count == 1 else f"{count} numbers"
            self.faults.add(e.where, f'{name}="{shown}" is not {what}', "correct it")
        elif any(not math.isfinite(x) or abs(x) > MAX_MAGNITUDE for x in values):
            self.faults.add(e.where, f'{name}="{shown}" is implausibly large', "use SI units: m, kg, rad")
        elif any(x <= above for x in values):
            self.faults.add(e.where, f'{name}="{shown}" must be more than {above:g}', "correct it")
        else:
            return values if len(values) == count else (1.0,) * count
        return (1.0,) * count

    def scale(self, e: Element) -> tuple[float, ...]:
        """Return the scale of a mesh along each axis; negative values mirror it."""
        factors = self.numbers(e, "scale", 3, (1.0, 1.0, 1.0))
        if 0 in factors:
            self.faults.add(e.where, "its scale is 0", "make it other than 0")
            return (1.0, 1.0, 1.0)
        return factors


def read_xml(path: Path, shown: str, faults: Faults) -> Element:
    """Return the root element of a file. Raises Broken, after adding the fault, if it is no XML or too large."""
    try:
        with open_file(path) as file:
            content = file.read(XML_BYTES.most + 1)
    except OSError as error:
        raise faults.stop(FilePlace(shown), f"cannot be read: {error.strerror}", "make it readable") from None
    if len(content) > XML_BYTES.most:
        raise faults.stop(FilePlace(shown), XML_BYTES.sentence, XML_BYTES.help)
    return _Builder(shown, faults).read(content)


class _Builder:
    """Builds the element tree from parser events."""

    def __init__(self, shown: str, faults: Faults) -> None:
        self._shown = shown
        self._faults = faults
        self._open: list[Element] = [Element("", {}, 0, shown)]
        self._count = 0
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = lambda _: self._open.pop()
        self._parser.StartDoctypeDeclHandler = self._doctype

    def read(self, content: bytes) -> Element:
        top = self._open[0]
        start = content.find(b"<?xml")
        if start > 0:  # a declaration behind a comment is no XML; simple parsers read it
            stop = content.find(b"?>", start) + 2
            content = content[:start] + re.sub(rb"[^\n]", b" ", content[start:stop]) + content[stop:]
        try:
            self._parser.Parse(content, True)
        except UnreadableAsset:
            raise
        except (expat.ExpatError, ValueError, LookupError) as error:
            if not (top.children and len(self._open) == 1):  # what follows the root does not matter
                raise self._stop(f"is no XML: {error}", "fix it, or export it again") from None
        return top.children[0]

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if self._count > XML_ELEMENTS.most:
            raise self._stop(XML_ELEMENTS.sentence, XML_ELEMENTS.help)
        if len(self._open) > XML_DEPTH.most:
            raise self._stop(XML_DEPTH.sentence, XML_DEPTH.help)
        made = Element(tag[:60], attributes, self._parser.CurrentLineNumber, self._shown)
        self._open[-1].children.append(made)
        self._open.append(made)

    def _doctype(self, *_: object) -> None:
        raise self._stop("has a DTD, which is not allowed", "remove the line `<!DOCTYPE`")

    def _stop(self, message: str, help: str) -> UnreadableAsset:
        return self._faults.stop(FilePlace(self._shown, self._parser.CurrentLineNumber), message, help)
