"""Small stages written inline, and scenes compared."""

from __future__ import annotations

import re
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Usd

DATA = Path(__file__).parent / "data"
HEADER = (
    '#usda 1.0\n(defaultPrim = "World"\n metersPerUnit = {meters}\n kilogramsPerUnit = {kilograms}\n upAxis = "{up}")\n'
)


def stage(body: str, *, meters: float = 1, kilograms: float = 1, up: str = "Z") -> Usd.Stage:
    """A stage of prims under /World."""
    layer = Sdf.Layer.CreateAnonymous("inline.usda")
    header = HEADER.format(meters=meters, kilograms=kilograms, up=up)
    assert layer.ImportFromString(header + lines(f'def Xform "World" {{ {body} }}\n'))
    return Usd.Stage.Open(layer)


_STATEMENT = re.compile(
    r"(?<!uniform) (?=(?:uniform )?"
    r"(?:double3?|float[23]?|int|bool|token|string|rel|(?:vector3|point3|color3|texCoord2)f|quat[fd])"
    r"(?:\[\])? [\w:.]+)"
)


def lines(text: str) -> str:
    """Short tests put several statements on a line, which USD does not allow."""
    text = re.sub(r"\b(def|class|over|prepend) ", r"\n\1 ", text.replace("{", "{\n").replace("}", "\n}\n"))
    return _STATEMENT.sub("\n", text)


def assert_same(a: Any, b: Any, where: str = "scene", skip: tuple[str, ...] = ()) -> None:
    """Equal up to rounding; a quaternion equals its negative."""
    assert type(a) is type(b), where
    if is_dataclass(a):
        for field in fields(a):
            if field.name not in skip:
                assert_same(getattr(a, field.name), getattr(b, field.name), f"{where}.{field.name}", skip)
    elif isinstance(a, tuple):
        assert len(a) == len(b), where
        for i, (x, y) in enumerate(zip(a, b, strict=True)):
            assert_same(x, y, f"{where}[{i}]", skip)
    elif isinstance(a, np.ndarray):
        turned = a.shape == (4,) and a @ b < 0
        np.testing.assert_allclose(a, -b if turned else b, rtol=1e-6, atol=1e-7, err_msg=where)
    elif isinstance(a, float):
        np.testing.assert_allclose(a, b, rtol=1e-6, atol=1e-7, err_msg=where)
    else:
        assert a == b, where
