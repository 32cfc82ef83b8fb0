"""Substitutes values for names in the syntax tree."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.parser import MAX_DEPTH

#: Maximum size of a task after expansion of templates and sets (syntax nodes): about one second of checking.
MAX_NODES = 200_000
_THING = 50

Values = Mapping[str, s.Expr]


class TooLarge(Exception):
    """The expansion is too large or nested too deeply."""


class Substitute:
    """Bounded substitution for one task: a small text may expand to a large one."""

    def __init__(self) -> None:
        self._left = MAX_NODES

    def expression(self, e: s.Expr, values: Values) -> s.Expr:
        """Return the expression with names replaced; spans stay unchanged. Raises TooLarge."""
        made = _expression(e, values)
        self._count(made)
        return made

    def count_entity(self) -> None:
        """Count an expanded entity with its default properties. Raises TooLarge."""
        self._left -= _THING

    def property(self, p: s.Property, values: Values) -> s.Property:
        """Return a property with names replaced. Raises TooLarge."""
        at = self.expression(p.at, values) if p.at is not None else None
        return replace(p, value=self.expression(p.value, values), at=at)

    def part(self, part: s.Part, values: Values) -> s.Part:
        """Return a part with names replaced. Raises TooLarge."""
        return replace(part, properties=tuple(self.property(p, values) for p in part.properties))

    def _count(self, e: s.Expr) -> None:
        stack = [(e, 0)]
        while stack:
            node, depth = stack.pop()
            self._left -= 1
            if self._left < 0 or depth > MAX_DEPTH:
                raise TooLarge
            stack += [(child, depth + 1) for child in _children(node)]


def _expression(e: s.Expr, values: Values) -> s.Expr:
    match e:
        case s.Name():
            return values.get(e.id, e)
        case s.Member():
            return replace(e, value=_expression(e.value, values))
        case s.Index():
            return replace(e, value=_expression(e.value, values), index=_expression(e.index, values))
        case s.Call():
            function = e.function if isinstance(e.function, s.Name) else _expression(e.function, values)
            arguments = tuple(replace(a, value=_expression(a.value, values)) for a in e.arguments)
            return replace(e, function=function, arguments=arguments)
        case s.Operation():
            return replace(e, operands=tuple(_expression(o, values) for o in e.operands))
        case s.Items():
            return replace(e, items=tuple(_expression(i, values) for i in e.items))
        case s.Range():
            ends = (e.start, e.stop, e.step, e.count)
            start, stop, step, count = (_expression(x, values) if x is not None else None for x in ends)
            assert start is not None
            assert stop is not None
            return replace(e, start=start, stop=stop, step=step, count=count)
        case s.WhatIf():
            return replace(e, value=_expression(e.value, values))
        case s.Cause():
            condition, candidates = _expression(e.condition, values), _expression(e.candidates, values)
            return replace(e, condition=condition, candidates=candidates)
    return e


def _children(e: s.Expr) -> tuple[s.Expr, ...]:
    match e:
        case s.Member():
            return (e.value,)
        case s.Index():
            return e.value, e.index
        case s.Call():
            return e.function, *(a.value for a in e.arguments)
        case s.Operation():
            return e.operands
        case s.Items():
            return e.items
        case s.Range():
            return tuple(x for x in (e.start, e.stop, e.step, e.count) if x is not None)
        case s.WhatIf():
            return (e.value,)
        case s.Cause():
            return e.condition, e.candidates
    return ()
