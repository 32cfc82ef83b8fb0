"""Compiles MJCF with MuJoCo, which resolves defaults, frames, replication, fitted primitives, masses and actuators."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from wmspec.core.native_output import silence
from wmspec.core.places import FilePlace
from wmspec.lang.importers.markup import Element
from wmspec.lang.importers.mjcf_source import Source
from wmspec.lang.importers.model import MAX_KINDS, Faults, UnreadableAsset

_LINE = re.compile(r"line (\d+)")
_HELP = "correct it; the MuJoCo XML reference describes the element"
#: Elements that can be removed to find errors behind theirs.
_REMOVABLE = frozenset({"geom", "joint", "freejoint", "inertial", "mesh", "material", "exclude"})


class Compiled:
    """A compiled model: MuJoCo's `model`, and the place of each body, joint, geom and actuator in the files.

    `has_contacts` is whether geoms can collide at all.
    """

    def __init__(self, mujoco: Any, spec: Any, model: Any, source: Source) -> None:
        self.mujoco, self.model, self.source = mujoco, model, source
        self.bodies = [self._element(b) for b in sorted(spec.bodies, key=lambda b: b.id)]
        self.joints = [self._element(j) for j in sorted(spec.joints, key=lambda j: j.id)]
        self.geoms = [self._element(g) for g in sorted(spec.geoms, key=lambda g: g.id)]
        self.actuators = [self._element(a) for a in sorted(spec.actuators, key=lambda a: a.id)]
        self.has_contacts = not int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
        self.meshes = {mesh.name: mesh for mesh in spec.meshes}

    def _element(self, of: Any) -> Element:
        found = _LINE.search(of.info)
        return self.source.element(int(found[1]) if found else 1)


def compiled(source: Source, faults: Faults) -> Compiled:
    """Return the compiled model. Raises UnreadableAsset, after adding all faults, if MuJoCo refuses it."""
    try:
        import mujoco
    except ImportError:
        where = FilePlace(source.root.file)
        raise faults.stop(where, "reading MJCF needs MuJoCo", "pip install 'wmspec[mujoco]'") from None
    for _ in range(MAX_KINDS):
        text = source.text()
        try:
            with _quiet(mujoco):
                spec = mujoco.MjSpec.from_string(text, assets=source.assets)
                made = Compiled(mujoco, spec, spec.compile(), source)
        except (ValueError, mujoco.FatalError, RuntimeError, MemoryError) as error:
            if not _reported(str(error), source, faults):
                break
            continue
        if faults.diagnostics:
            break
        return made
    raise UnreadableAsset


def _reported(message: str, source: Source, faults: Faults) -> bool:
    """Report an error of MuJoCo; whether its element could be removed to find the next one."""
    line = _LINE.search(message)
    element = source.element(int(line[1]) if line else 1)
    text = message.removeprefix("XML Error: ").removeprefix("Error: ").partition("\nElement")[0].strip()
    faults.add(element.where, f"MuJoCo refuses it: {text[:300]}", _HELP)
    return element.tag in _REMOVABLE and _removed(source.root, element)


def _removed(root: Element, element: Element) -> bool:
    for e in root.children:
        if e is element:
            root.children.remove(e)
            return True
        if _removed(e, element):
            return True
    return False


@contextmanager
def _quiet(mujoco: Any) -> Iterator[None]:
    """Suppress MuJoCo's warnings and its log file."""
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        with silence():
            yield
    finally:
        mujoco.set_mju_user_warning(previous)
