"""Converts links and joints of an asset to objects and joints of the language, with the spec's overrides."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

from wmspec.core.diagnostics import Diagnostic
from wmspec.lang.check.tables.property_schema import APPEARANCE
from wmspec.lang.check.tables.vocabulary import Y_UP
from wmspec.lang.importers import model
from wmspec.lang.importers.model import Form, Joint, Link, MeshFile, RejectedAsset, Shape, grouped
from wmspec.lang.importers.tree import LinkTree, PlacedLink
from wmspec.lang.importers.turns import angles, without_rounding
from wmspec.lang.importers.write import Writer
from wmspec.lang.parse import syntax as s
from wmspec.sim.shapes import shape_word

#: Properties of links, and of joints, that a spec may override.
OF_LINK = (
    *APPEARANCE, "mass", "density", "friction", "restitution", "damping", "spin_damping", "collision", "fixed",
    "velocity", "spin", "surface_velocity", "passes",
)  # fmt: skip
OF_JOINT = ("low", "high", "start", "target", "stiffness", "damping", "pace", "strength", "armature", "touching")
#: Properties of the whole asset that apply to every link, beyond its appearance.
_COMMON = ("density", "friction", "restitution", "damping")
#: Properties of the object that say how its file is read.
OF_ASSET = ("collision", "strict", "inertia")
#: Units of shape parameters other than lengths and points.
_SIZES = {"number": None, "angle": "rad"}
_UNITS = {"density": "kg/m^3", "damping": "Hz", "spin_damping": "Hz"}

Overrides = Mapping[str, tuple[s.Property, ...]]


def to_identifier(name: str) -> str:
    """Return a name of the file as an identifier: other characters become `_`."""
    made = re.sub(r"\W", "_", name, flags=re.ASCII)
    return made if not made[:1].isdigit() else f"_{made}"


def relevant_faults(
    of: LinkTree | RejectedAsset, overrides: Overrides, whole: Collection[str]
) -> tuple[Diagnostic, ...]:
    """Return the relevant errors and warnings by kind, given the spec's overrides of links and of the `whole`."""
    mistakes = dict.fromkeys(of.diagnostics if isinstance(of, RejectedAsset) else of.warnings)
    for link in of.links if isinstance(of, RejectedAsset) else (placed.link for placed in of.links):
        own = {p.name.id for p in overrides.get(to_identifier(link.name), ())}
        conditional = (c for shape in link.shapes for c in (*shape.look.conditional, *shape.conditional))
        mistakes |= {c.diagnostic: None for c in conditional if not {*own, *whole}.intersection(c.unless)}
    return grouped(mistakes)


@dataclass(frozen=True)
class Blocks:
    """Converts an asset; `base` is the object that names it, `overrides` are the spec's properties of its links.

    `own_inertia` keeps the file's inertias even if they are impossible.
    """

    base: s.Block
    tree: LinkTree
    overrides: Overrides
    write: Writer
    own_inertia: bool = False

    def name(self, of: str) -> str:
        """Return the block name of a link or joint."""
        first = self.tree.links[0].link.name
        return self.base.name.id if of == first else f"{self.base.name.id}_{to_identifier(of)}"

    def all(self) -> tuple[s.Block, ...]:
        """Return the base, the other links, and the joints."""
        first, *others = self.tree.links
        return self._base(first.link), *(self._link(p) for p in others), *(self._joint(j) for j in self.tree.joints)

    def _base(self, link: Link) -> s.Block:
        here = {p.name.id for p in self.base.properties}
        stands = (self.tree.held or link.fixed) and "fixed" not in here
        held: dict[str, s.Expr] = {"fixed": self.write.truth(True)} if stands else {}
        own = tuple(p for p in self.base.properties if p.name.id not in ("file", *OF_ASSET))
        properties = _with_overrides(
            (*own, *self.write.properties(held | self._from_file(link))), self._overrides_of(link)
        )
        made = (*properties, *self.write.properties(self._mass_properties(link, properties)))
        return replace(self.base, properties=made, parts=self._parts(link, properties))

    def _link(self, placed: PlacedLink) -> s.Block:
        link, base = placed.link, self.base.name.id
        yaw, pitch, roll = angles(placed.pose.orientation)
        at = self.write.numbers(without_rounding(placed.pose.position), "m")
        turns = {"yaw": yaw, "pitch": pitch, "roll": roll}
        where = {"at": at, **{name: self.write.number(angle, "rad") for name, angle in turns.items()}}
        if link.fixed:
            where["fixed"] = self.write.truth(True)
        whole = {p.name.id for p in self.base.properties}
        common = ("present", *_COMMON, *(look for look in APPEARANCE if look in whole))
        shared = self.write.properties({name: self.write.of(base, name) for name in common} | self._from_file(link))
        properties = _with_overrides((*self.write.properties(where), *shared), self._overrides_of(link))
        made = (*properties, *self.write.properties(self._mass_properties(link, properties)))
        parts = self._parts(link, properties)
        name = s.Name(self.name(link.name), self.base.name.span)
        return s.Block("object", name, made, self.write.span, parts=parts, whole=base)

    def _overrides_of(self, link: Link) -> tuple[s.Property, ...]:
        """Return the overrides of a link, without those that apply to its parts."""
        return tuple(p for p in self.overrides.get(to_identifier(link.name), ()) if p.name.id != "collision")

    # ------------------------------------------------------------ what a link is made of

    def _from_file(self, link: Link) -> dict[str, s.Expr]:
        """Return the file's properties of a link except its mass, unless the spec sets them for the whole."""
        whole = {p.name.id for p in self.base.properties}
        values = {n: self.write.number(x, _UNITS.get(n)) for n, x in link.given.items()}
        if link.velocity is not None:
            values["velocity"] = self.write.numbers(without_rounding(link.velocity), "m/s")
        if link.spin is not None:
            values["spin"] = self.write.numbers(without_rounding(link.spin), "rad/s")
        if link.surface_velocity is not None:
            values["surface_velocity"] = self.write.numbers(link.surface_velocity, "m/s")
        if link.passes:
            values["passes"] = self.write.names(self.name(other) for other in link.passes)
        return {n: made for n, made in values.items() if n not in whole}

    def _mass_properties(self, link: Link, properties: tuple[s.Property, ...]) -> dict[str, s.Expr]:
        """Return mass, centre and moments; empty if the spec sets the density."""
        names = {p.name.id for p in properties}
        by_density = "density" in {p.name.id for p in (*self.base.properties, *self._overrides_of(link))}
        mass = link.own_inertia if link.own_inertia is not None and self.own_inertia else link.mass
        if mass is None or by_density:
            return {}
        values = {} if "mass" in names else {"mass": self.write.number(mass.mass, "kg")}
        own = self.write.of(self.name(link.name), "mass")
        values["centre"] = self.write.numbers(without_rounding(mass.center), "m")
        values["moments"] = self.write.times((float(m) / mass.mass for m in mass.moments), "m^2", own)
        values["axes"] = self.write.numbers(angles(mass.axes), "rad")
        return values

    def _parts(self, link: Link, properties: tuple[s.Property, ...]) -> tuple[s.Part, ...]:
        names = {p.name.id for p in properties}
        looks = set(APPEARANCE) - names if not names.intersection(model.OVERRIDING_PROPERTIES) else set()
        ways = (*self.overrides.get(to_identifier(link.name), ()), *self.base.properties)
        touched = next((p.value for p in ways if p.name.id == "collision"), None)
        spec = {p.name.id for p in (*self.base.properties, *self._overrides_of(link))}
        files = {*looks, *({"friction", "restitution"} - spec)}
        return tuple(self._part(i, shape, files, touched) for i, shape in enumerate(link.shapes))

    def _part(self, i: int, shape: Shape, files: Collection[str], touched: s.Expr | None) -> s.Part:
        """Return a shape as a part. `files` are the properties taken from the file, `touched` overrides the collision
        mode of meshes.
        """
        yaw, pitch, roll = angles(shape.pose.orientation)
        values = {
            **self._form(shape.form, touched),
            "at": self.write.numbers(without_rounding(shape.pose.position), "m"),
            **{n: self.write.number(a, "rad") for n, a in (("yaw", yaw), ("pitch", pitch), ("roll", roll)) if a},
        }
        values |= {name: made for name, made in (self._look(shape) | self._friction(shape)).items() if name in files}
        if not shape.solid:
            values["solid"] = self.write.truth(False)
        if not shape.drawn:
            values["drawn"] = self.write.truth(False)
        return s.Part(self.write.name(f"shape_{i}"), self.write.properties(values), self.write.span)

    def _look(self, shape: Shape) -> dict[str, s.Expr]:
        look = shape.look
        given = {name: x for name, x in (("roughness", look.roughness), ("metallic", look.metallic)) if x is not None}
        made: dict[str, s.Expr] = {name: self.write.number(x) for name, x in given.items()}
        if look.color is not None:
            made["color"] = self.write.color(look.color)
        if look.image:
            made["image"] = self.write.text(look.image)
        return made | ({"repeats": self.write.numbers(look.repeats)} if look.image and look.repeats else {})

    def _friction(self, shape: Shape) -> dict[str, s.Expr]:
        given = zip(("friction", "restitution"), shape.friction_restitution or (), strict=False)
        return {name: self.write.number(x) for name, x in given}

    def _form(self, form: Form, touched: s.Expr | None) -> dict[str, s.Expr]:
        if isinstance(form, MeshFile):
            way = touched or self.write.name(form.collision)
            made = {"file": self.write.text(form.file), "scale": self.write.numbers(form.scale), "collision": way}
            return made | ({"up": self.write.name("z")} if form.file.lower().endswith(Y_UP) else {})
        units = {name: _SIZES.get(own.kind, "m") for name, own in form.properties.items()}
        sizes = {name: self.write.value(size, units.get(name, "m")) for name, size in form.words.items()}
        return {"shape": self.write.name(shape_word(form)), **sizes}

    # ------------------------------------------------------------ joints

    def _joint(self, joint: Joint) -> s.Block:
        values: dict[str, s.Expr] = {"of": self.write.name(self.name(joint.child))}
        if joint.parent:
            values["to"] = self.write.name(self.name(joint.parent))
        values["at"] = self.write.numbers(without_rounding(joint.at), "m")
        if joint.touching:
            values["touching"] = self.write.truth(True)
        if joint.kind in ("hinge", "slider"):
            values |= self._coordinate(joint)
        properties = _with_overrides(self.write.properties(values), self.overrides.get(to_identifier(joint.name), ()))
        name = s.Name(self.name(joint.name), self.base.name.span)
        model = self.write.name(joint.kind)
        return s.Block("joint", name, properties, self.write.span, model, whole=self.base.name.id)

    def _coordinate(self, joint: Joint) -> dict[str, s.Expr]:
        """Return axis, limits and damping; the start is 0 or the nearest limit."""
        unit = "rad" if joint.kind == "hinge" else "m"
        low, high = (-math.inf if joint.low is None else joint.low), (math.inf if joint.high is None else joint.high)
        start = joint.start if joint.start is not None else max(low, min(high, 0.0))
        numbers = (("low", joint.low), ("high", joint.high), ("start", start or None), ("target", joint.target))
        values = {name: self.write.number(value, unit) for name, value in numbers if value is not None}
        drive = (joint.stiffness, joint.damping, joint.pace, joint.strength, joint.armature)
        plain_numbers = zip(("stiffness", "damping", "pace", "strength", "armature"), drive, strict=True)
        values |= {name: self.write.number(value) for name, value in plain_numbers if value}
        return {"axis": self.write.numbers(without_rounding(joint.axis)), **values}


def _with_overrides(made: tuple[s.Property, ...], instead: tuple[s.Property, ...]) -> tuple[s.Property, ...]:
    """Return properties with overrides applied."""
    names = {p.name.id for p in instead}
    return *(p for p in made if p.name.id not in names), *instead
