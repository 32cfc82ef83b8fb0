"""Going on after a mistake: what the parser could read next, and where reading can go on.

Lark's own `accepts` copies the whole parser for every terminal. Here the parser's table is followed on its stack of
states alone, which takes time in proportion to the reductions made.
"""

from __future__ import annotations

from lark import Token
from lark.parsers.lalr_analysis import Shift
from lark.parsers.lalr_interactive_parser import InteractiveParser

#: Words that begin a statement or clause: after a mistake, reading goes on at the next of them.
STARTERS = frozenset({
    "TASK", "USE", "FACTOR", "NUISANCE", "LET", "REQUIRE", "REPEAT", "DESIGN", "TOLERANCE", "TEMPLATE", "OBJECT",
    "OBJECTS", "CAMERA", "LIGHT", "JOINT", "ROBOT", "WORLD", "ACTION", "HORIZON", "OBSERVE", "QUESTION", "SETTING",
    "OPTIONS", "ANSWER", "MARGIN", "ENSURE", "DISTINCT", "WITHIN", "DIFFERENCE", "STABLE", "COUNTERFACTUAL"
})  # fmt: skip


def accepted(parser: InteractiveParser) -> set[str]:
    """The terminals that the parser could read next."""
    state = parser.parser_state
    choices = state.parse_conf.states[state.position]
    return {terminal for terminal in choices if terminal.isupper() or terminal == "$END" if takes(parser, terminal)}


def takes(parser: InteractiveParser, terminal: str, depth: int | None = None) -> bool:
    """Whether the parser could read this terminal next, if only the first `depth` of its states were on the stack."""
    stack, conf = parser.parser_state.state_stack, parser.parser_state.parse_conf
    left = len(stack) if depth is None else depth
    pushed: list[int] = []
    while True:
        action = conf.states[pushed[-1] if pushed else stack[left - 1]].get(terminal)
        if action is None:
            return False
        kind, rule = action
        if kind is Shift:
            return True
        size = len(rule.expansion)
        left -= max(0, size - len(pushed))
        del pushed[max(0, len(pushed) - size) :]
        pushed.append(conf.states[pushed[-1] if pushed else stack[left - 1]][rule.origin.name][1])
        if terminal == "$END" and pushed[-1] == conf.end_state:
            return True


def recover(parser: InteractiveParser, tokens: list[Token], i: int) -> int:
    """Drop tokens up to the next start of a statement, property or `}`, and what was half read before it.

    Returns the index of the token to go on with; past the end if nothing fits.
    """
    stuck = i
    while i < len(tokens):
        if (i > stuck or tokens[i].type in STARTERS) and _boundary(tokens, i) and _unwind(parser, tokens[i].type):
            return i
        i += 1
    return i


def _boundary(tokens: list[Token], i: int) -> bool:
    return tokens[i].type in STARTERS or tokens[i].type in ("RBRACE", "$END") or tokens[i + 1].type == "COLON"


def _unwind(parser: InteractiveParser, terminal: str) -> bool:
    """Pop the parser's stack until it could go on with this terminal; leave it alone if it never could."""
    state = parser.parser_state
    for depth in range(len(state.state_stack), 0, -1):
        if takes(parser, terminal, depth):
            del state.state_stack[depth:]
            del state.value_stack[max(0, depth - 1) :]
            return True
    return False
