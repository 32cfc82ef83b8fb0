"""The file `page.toml` of a study: what the page says, for translation, and how people complete the study."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError, model_validator

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.resources import resource
from wmspec.core.safe_io import read_bytes, read_text
from wmspec.eval.models.prompt import FrozenModel

#: Its name among the texts of a study.
WORDING_FILE = "page.toml"


class Completion(FrozenModel):
    """The end of a study: a code for all people, or '' for a code of their own; and the address where they go."""

    code: str = Field(default="", pattern=r"^[A-Za-z0-9._-]{0,64}$")
    url: str = Field(default="", pattern=r"^(https://[^\s\"'<>]+)?$")


class Wording(FrozenModel):
    """The content of the file. Texts have the placeholders of the texts that they translate."""

    completion: Completion
    texts: dict[str, str]

    @model_validator(mode="after")
    def _complete(self) -> Wording:
        known = default_texts()
        if set(self.texts) != set(known):
            name = min(set(self.texts) ^ set(known))
            raise ValueError(f"texts.{name} is {'unknown' if name in self.texts else 'missing'}")
        for name, text in self.texts.items():
            if unknown := _placeholders(text) - _placeholders(known[name]):
                raise ValueError(f"texts.{name}: `{{{min(unknown)}}}` cannot stand here")
        return self


def default_wording() -> str:
    """Return the file in English."""
    return read_text(resource(f"eval/study/texts/{WORDING_FILE}"))


def default_texts() -> dict[str, str]:
    """Return the English texts by name."""
    texts: dict[str, str] = tomllib.loads(default_wording())["texts"]
    return texts


def read_wording(path: Path) -> Wording:
    """Read the file. Raises WmsError if it cannot be read, or if a text is missing, unknown or invalid."""
    try:
        values: Any = tomllib.loads(read_bytes(path).decode("utf-8"))
        return Wording.model_validate(values)
    except FileNotFoundError:
        raise WmsError("is missing", FilePlace(str(path)), "`wmspec study make` writes it again") from None
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(map(str, first["loc"]))
        message = ": ".join(filter(None, [field, first["msg"].removeprefix("Value error, ")]))
        remedy = "correct it, or delete it, and `wmspec study make` writes it again"
        raise WmsError(message, FilePlace(str(path)), remedy) from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise WmsError(f"cannot be read ({error})", FilePlace(str(path)), "correct it, or delete it") from None


def _placeholders(text: str) -> set[str]:
    return set(re.findall(r"\{(\w+)\}", text))
