"""Evaluates variable expressions in asset paths, bounded: a few nested variables can expand to gigabytes."""

from __future__ import annotations

import re
from collections.abc import Mapping

from pxr import Sdf

from wmspec.core.limits import EXPRESSION_LENGTH

Variables = tuple[tuple[str, object], ...]

_REFERENCE = re.compile(r"\$\{([^}]*)\}")
#: Nesting from which variables are cyclic or made to expand.
_DEPTH = 20


def variables_of(layer: Sdf.Layer, outer: Variables) -> Variables:
    """Return the variables of a layer stack with this root, of which those of the referencing stack are stronger."""
    return tuple(sorted({**dict(layer.expressionVariables), **dict(outer)}.items(), key=lambda pair: pair[0]))


def evaluated(path: str, variables: Variables) -> str:
    """Return an asset path with its expression evaluated; '' if that is invalid, which USD reports.

    Raises TooLarge if the expression, with its variables expanded, is too long.
    """
    if not Sdf.VariableExpression.IsExpression(path):
        return path
    known = dict(variables)
    if _expanded_length(path, known, 0) > EXPRESSION_LENGTH.most:
        raise EXPRESSION_LENGTH.exceeded()
    result = Sdf.VariableExpression(path).Evaluate(known)
    return result.value if isinstance(result.value, str) and not result.errors else ""


def _expanded_length(text: str, known: Mapping[str, object], depth: int) -> int:
    """Return an upper bound on the length of a text after its variables are expanded."""
    length = len(text)
    if depth > _DEPTH or length > EXPRESSION_LENGTH.most:
        raise EXPRESSION_LENGTH.exceeded()
    for name in _REFERENCE.findall(text):
        value = known.get(name)
        length += _expanded_length(value, known, depth + 1) if isinstance(value, str) else 0
        if length > EXPRESSION_LENGTH.most:
            raise EXPRESSION_LENGTH.exceeded()
    return length
