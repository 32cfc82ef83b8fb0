"""Signature help: the parameters of the verb or function whose brackets contain a place."""

from __future__ import annotations

from dataclasses import dataclass

from wmspec.editor.complete import accepted_values
from wmspec.editor.document import Document
from wmspec.editor.names import Names
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.tables.verbs import ROBOTS, VERBS, Verb
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.lexer import Token, tokenize

_CLOSING = {"RPAR": "LPAR", "RSQB": "LSQB", "RBRACE": "LBRACE"}


@dataclass(frozen=True)
class Parameter:
    """A parameter as it appears in the signature, and its meaning."""

    label: str
    meaning: str


@dataclass(frozen=True)
class Signature:
    """A signature with its meaning; `active` is the index of the parameter at the place, or None."""

    label: str
    meaning: str
    parameters: tuple[Parameter, ...]
    active: int | None


@dataclass(frozen=True)
class _OpenCall:
    """A call whose brackets are open: its function, the robot before it, and the tokens of the argument."""

    function: str
    robot: str
    position: int
    named: str


def signature_at(document: Document, offset: int) -> Signature | None:
    """Return the signature of the innermost open call before an offset, or None."""
    call = _open_call([t for t in tokenize(document.text[:offset]) if t.type not in ("WHITE", "COMMENT")])
    if call is None:
        return None
    if call.robot or call.function in VERBS:
        verb = _verb(document, offset, call)
        return None if verb is None else _verb_signature(call, verb)
    return _function_signature(call) if call.function in FUNCTIONS else None


def _open_call(tokens: list[Token]) -> _OpenCall | None:
    """Return the innermost call that is open at the end of the tokens."""
    if tokens and tokens[-1].type == "OPEN_STRING":
        return None
    deep, commas = 0, 0
    for i in range(len(tokens) - 1, 0, -1):
        kind = tokens[i].type
        deep += (kind in _CLOSING) - (kind in _CLOSING.values())
        if deep == 0 and kind == "COMMA":
            commas += 1
        if deep < 0 and (kind != "LPAR" or tokens[i - 1].type != "NAME"):
            return None
        if deep < 0:
            robot = tokens[i - 3].text if i > 2 and tokens[i - 2].type == "DOT" else ""
            return _OpenCall(tokens[i - 1].text, robot, commas, _named(tokens[i + 1 :]))
    return None


def _named(tokens: list[Token]) -> str:
    """Return the name of the last argument, or ''."""
    deep = 0
    for i in range(len(tokens) - 1, -1, -1):
        deep += (tokens[i].type in _CLOSING) - (tokens[i].type in _CLOSING.values())
        if deep == 0 and tokens[i].type == "COLON" and i:
            return tokens[i - 1].text
        if deep == 0 and tokens[i].type == "COMMA":
            return ""
    return ""


def _verb(document: Document, offset: int, call: _OpenCall) -> Verb | None:
    if not call.robot:
        return VERBS[call.function]
    declared = Names(document).visible(offset).get(call.robot)
    node = declared.node if declared is not None else None
    model = node.model.id if isinstance(node, s.Block) and node.model is not None else ""
    return ROBOTS.get(model, {}).get(call.function)


def _verb_signature(call: _OpenCall, verb: Verb) -> Signature:
    names = list(verb.arguments)
    parameters = tuple(Parameter(f"{n}: {accepted_values(x)}", x.meaning) for n, x in verb.arguments.items())
    if call.named:
        active = names.index(call.named) if call.named in names else None
    else:
        active = call.position if call.position < len(names) else None
    whose = f"{call.robot}." if call.robot else ""
    label = f"{whose}{call.function}({', '.join(p.label for p in parameters)}){' for TIME' if verb.lasts else ''}"
    return Signature(label, verb.meaning, parameters, active)


def _function_signature(call: _OpenCall) -> Signature:
    function = FUNCTIONS[call.function]
    parameters = [Parameter(str(kind), "") for kind in function.parameters]
    if function.repeated:
        parameters.append(Parameter("...", "more of the same"))
    names = list(function.options)
    options = [Parameter(f"{name}: {kind}", "") for name, kind in function.options.items()]
    if call.named:
        active = len(parameters) + names.index(call.named) if call.named in names else None
    else:
        active = min(call.position, len(parameters) - 1) if function.repeated else call.position
        active = active if active < len(parameters) else None
    every = (*parameters, *options)
    return Signature(f"{call.function}({', '.join(p.label for p in every)})", function.meaning, every, active)
