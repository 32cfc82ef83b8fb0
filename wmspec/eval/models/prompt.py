"""Prompt templates, TOML files that determine how questions are presented. The built-in ones are in `prompts/`."""

from __future__ import annotations

import hashlib
import json
import re
import tomllib
from collections.abc import Collection, Mapping
from functools import cache
from pathlib import Path
from typing import Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.resources import resource
from wmspec.core.safe_io import read_text

Labels = Literal["letters", "numbers"]
Part = Literal["pictures", "question", "option_words", "option_pictures", "instruction"]


class FrozenModel(BaseModel):
    """A model that cannot be changed and has no other fields than its own."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class LabelKinds(FrozenModel):
    """The labels of options in words and of option pictures."""

    words: Labels
    pictures: Labels


class Texts(FrozenModel):
    """The texts of a template; an empty one omits its line."""

    picture: str
    picture_at: str
    clip: str
    clip_film: str
    montage: str
    montage_options: str
    options_alone: str
    option_words: str
    option_picture: str
    letters: str
    numbers: str
    open: str
    open_plain: str
    open_words: str
    none_of_others: str
    without_pictures: str
    without_question: str

    @model_validator(mode="after")
    def _placeholders(self) -> Texts:
        for name, text in self:
            check_placeholders(text, _permitted_placeholders()[name], f"texts.{name}")
        return self

    def line(self, name: str, **values: object) -> str:
        """Return a text with its placeholders filled."""
        return filled(getattr(self, name), values)


class Prompt(FrozenModel):
    """A template: system prompt, order of parts, presentation of pictures, and texts.

    Of a film, at most `frames` pictures are shown.
    """

    system: str
    parts: tuple[Part, ...]
    pictures: Literal["separate", "montage", "frames", "clip"]
    frames: int = Field(ge=2, le=1000)
    labels: LabelKinds
    texts: Texts

    @property
    def hash(self) -> str:
        """Twelve hex digits that identify the content of the template."""
        text = json.dumps(self.model_dump(), sort_keys=True, ensure_ascii=False)
        return hashlib.sha256(text.encode()).hexdigest()[:12]


def check_placeholders(text: str, known: Collection[str], where: str) -> None:
    """Raise ValueError if a text has a placeholder that is not known."""
    for word in re.findall(r"\{(\w*)\}", text):
        if word not in known:
            raise ValueError(f"`{{{word}}}` cannot stand in {where}; {suggestion(word, known)}".rstrip("; "))


@cache
def _permitted_placeholders() -> dict[str, list[str]]:
    """Return the placeholders of each text: those of the default template, and the number of options for labels."""
    known = {name: re.findall(r"\{(\w*)\}", text) for name, text in _read("default")["texts"].items()}
    return known | {name: ["count"] for name in get_args(Labels)}


def filled(text: str, values: Mapping[str, object]) -> str:
    """Return a text with its placeholders filled."""
    return re.sub(r"\{(\w+)\}", lambda match: str(values[match[1]]), text)


def builtin_prompts() -> list[str]:
    """Return the names of the built-in templates."""
    return sorted(path.stem for path in resource("eval/models/prompts").glob("*.toml"))


def load(name: str) -> Prompt:
    """Load a template by name or path. Raises WmsError if it cannot be read or is invalid."""
    try:
        return Prompt.model_validate(_merged(name))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the template"
        message = first["msg"].removeprefix("Value error, ")
        raise WmsError(f"prompt {name}: {where}: {message}; `docs/evaluate.md` shows what a template says") from None


def _merged(name: str, depth: int = 0) -> dict[str, Any]:
    """Return the values of a template merged over those of the template that it extends."""
    values = _read(name)
    base = values.pop("extends", None)
    if base is None:
        return values
    if depth == 8 or not isinstance(base, str):
        raise WmsError(f"prompt {name}: extends: the name of another template, which does not extend this one")
    if name not in builtin_prompts() and base not in builtin_prompts():
        base = str(Path(name).parent / base)
    return _merge(_merged(base, depth + 1), values)


def _merge(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    both = {key for key in above if isinstance(above[key], dict) and isinstance(below.get(key), dict)}
    return {**below, **above, **{key: _merge(below[key], above[key]) for key in both}}


def _read(name: str) -> dict[str, Any]:
    file = resource("eval/models/prompts") / f"{name}.toml" if name in builtin_prompts() else Path(name)
    if not file.is_file():
        raise WmsError(f"there is no prompt `{name}`: {', '.join(builtin_prompts())}, or the path of a .toml file")
    try:
        return tomllib.loads(read_text(file))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise WmsError(f"prompt {file}: cannot be read ({error})") from None
