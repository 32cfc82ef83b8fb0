"""Prompt templates, TOML files: how a question is put to a model. Those that come with wmspec are in `prompts/`."""

from __future__ import annotations

import hashlib
import json
import re
import tomllib
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.resources import resource

Labels = Literal["letters", "numbers"]
Part = Literal["pictures", "question", "option_words", "option_pictures", "instruction"]

#: What may stand in braces in each text.
_PLACEHOLDERS = {
    "picture": {"number"},
    "clip": {"pictures"},
    "montage": {"pictures"},
    "montage_options": {"pictures", "labels"},
    "options_alone": {"labels"},
    "option_words": {"label", "words"},
    "option_picture": {"label"},
    "letters": {"count"},
    "numbers": {"count"},
    "open": {"unit"},
}


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=False)


class LabelKinds(_Model):
    """What options are called by: those in words, those that are pictures."""

    words: Labels
    pictures: Labels


class Texts(_Model):
    """The template's words; an empty one leaves its line out."""

    picture: str
    clip: str
    montage: str
    montage_options: str
    options_alone: str
    option_words: str
    option_picture: str
    letters: str
    numbers: str
    open: str
    open_plain: str
    without_pictures: str
    without_question: str

    @model_validator(mode="after")
    def _placeholders(self) -> Texts:
        for name, text in self:
            for word in re.findall(r"\{(\w*)\}", text):
                known = _PLACEHOLDERS.get(name, set())
                if word not in known:
                    raise ValueError(
                        f"`{{{word}}}` cannot stand in texts.{name}; {suggestion(word, known)}".rstrip("; ")
                    )
        return self

    def line(self, name: str, **values: object) -> str:
        """A text with its placeholders filled in."""
        text: str = getattr(self, name)
        return re.sub(r"\{(\w+)\}", lambda match: str(values[match[1]]), text)


class Prompt(_Model):
    """A template: the system's words, the order of a question's parts, how pictures are handed over, and its texts."""

    system: str
    parts: tuple[Part, ...]
    pictures: Literal["separate", "montage", "clip"]
    labels: LabelKinds
    texts: Texts

    @property
    def hash(self) -> str:
        """Twelve hex digits that depend on everything in the template, and on nothing else."""
        text = json.dumps(self.model_dump(), sort_keys=True, ensure_ascii=False)
        return hashlib.sha256(text.encode()).hexdigest()[:12]


def known() -> list[str]:
    """The names of the templates that come with wmspec."""
    return sorted(path.stem for path in resource("eval/models/prompts").glob("*.toml"))


def load(name: str) -> Prompt:
    """A template by name or as a file. Raises WmsError if it cannot be read or says what a template cannot."""
    try:
        return Prompt.model_validate(_merged(name))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the template"
        message = first["msg"].removeprefix("Value error, ")
        raise WmsError(f"prompt {name}: {where}: {message}; `docs/evaluate.md` shows what a template says") from None


def _merged(name: str, depth: int = 0) -> dict[str, Any]:
    """The values of a template over those of the one that it extends."""
    values = _read(name)
    base = values.pop("extends", None)
    if base is None:
        return values
    if depth == 8 or not isinstance(base, str):
        raise WmsError(f"prompt {name}: extends: the name of another template, which does not extend this one")
    if name not in known() and base not in known():
        base = str(Path(name).parent / base)
    return _over(_merged(base, depth + 1), values)


def _over(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    both = {key for key in above if isinstance(above[key], dict) and isinstance(below.get(key), dict)}
    return {**below, **above, **{key: _over(below[key], above[key]) for key in both}}


def _read(name: str) -> dict[str, Any]:
    file = resource("eval/models/prompts") / f"{name}.toml" if name in known() else Path(name)
    if not file.is_file():
        raise WmsError(f"there is no prompt `{name}`: {', '.join(known())}, or the path of a .toml file")
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise WmsError(f"prompt {file}: cannot be read ({error})") from None
