"""The reader of replies, shared by all models, studies and exports. Standard library only.

Exports contain a copy of this folder, so modules import each other relatively and nothing else of wmspec.
"""

from .choice import choice
from .mark import FINISHED_BY_FILTER, FINISHED_BY_LENGTH, Mark, Outcome, is_withheld, mark, mark_row
from .normalize import MAX_REPLY_LENGTH
from .numbers import is_near, number_in
from .shown import LETTERS, ORDINALS

#: Version of these rules, recorded with every result.
PARSER_VERSION = 3

__all__ = [
    "FINISHED_BY_FILTER",
    "FINISHED_BY_LENGTH",
    "LETTERS",
    "MAX_REPLY_LENGTH",
    "ORDINALS",
    "PARSER_VERSION",
    "Mark",
    "Outcome",
    "choice",
    "is_near",
    "is_withheld",
    "mark",
    "mark_row",
    "number_in",
]
